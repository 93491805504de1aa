/* A ball settles in a column of water: a solver in C, coupled with the particles of a Sturz daemon.
 *
 *   sturz serve settling.toml --name settling --paused &
 *   ./settling settling tcp/127.0.0.1:7447
 *
 * The column is 20 x 20 x 200 mm, closed below, in 50 cells of 4 mm above each other. Its "solver" is one line: water is
 * incompressible and the column closed, so that as much water flows up through each cell as solid goes down,
 * void_fraction u + (1 - void_fraction) v_solid = 0. Each window the particles move in the water of its start, and the water
 * then follows what they did. What the particles lost must be what the cells got, window by window.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "sturz.h"

#define CELLS 50
#define WINDOWS 200
static const double WIDTH_M = 0.02, HEIGHT_M = 0.2, WINDOW_S = 5e-3;
static const double DENSITY_KG_PER_M3 = 1000.0, BALL_KG_PER_M3 = 2500.0, GRAVITY_M_PER_S2 = 9.81;

/* Of the exchange: the cells' arrays. */
static double void_fraction[CELLS], solid_velocity[3 * CELLS], interaction[3 * CELLS];
static double water_velocity[3 * CELLS];

/* Ends the program with the reason where a call has failed. */
static void must(const char *what, sturz_code code)
{
    if (code == STURZ_OK)
        return;
    fprintf(stderr, "settling: %s: %s (code %d, at '%s')\n", what, sturz_last_error_message(), (int)code,
            sturz_last_error_path());
    exit(EXIT_FAILURE);
}

/* Ends the program where two numbers differ by more than rounding, relative to `size`. */
static void must_agree(const char *what, double one, double other, double size)
{
    if (fabs(one - other) <= 1e-9 * size)
        return;
    fprintf(stderr, "settling: %s: %.17g and %.17g should be equal\n", what, one, other);
    exit(EXIT_FAILURE);
}

/* What the totals say of the particles is what the cells have, and what their momentum did. */
static void check_conservation(const sturz_exchange *now, double momentum_before)
{
    const double cell_m3 = WIDTH_M * WIDTH_M * HEIGHT_M / CELLS, window_s = now->time_s - now->from_time_s;
    const double weight_n = now->solid_volume_m3 * BALL_KG_PER_M3 * GRAVITY_M_PER_S2;
    double solid_m3 = 0.0, impulse_n_s = 0.0;
    for (int i = 0; i < CELLS; i++) {
        solid_m3 += (1.0 - void_fraction[i]) * cell_m3;
        impulse_n_s += interaction[3 * i + 2] * cell_m3 * window_s;
    }
    must_agree("volume of the ball, and in the cells", now->immersed_volume_m3, solid_m3, now->solid_volume_m3);
    must_agree("impulse on the water, and in the cells", now->impulse_on_fluid_n_s[2], impulse_n_s,
               weight_n * window_s);
    const double change = -weight_n * window_s + now->buoyancy_impulse_n_s[2] + now->pressure_impulse_n_s[2]
                          - now->impulse_on_fluid_n_s[2];
    must_agree("momentum of the ball, and what acted on it", now->momentum_kg_m_per_s[2], momentum_before + change,
               weight_n * window_s);
}

/* The whole solver. */
static void solve_water(void)
{
    for (int i = 0; i < CELLS; i++)
        water_velocity[3 * i + 2] = -(1.0 - void_fraction[i]) * solid_velocity[3 * i + 2] / void_fraction[i];
}

int main(int argc, char **argv)
{
    if (argc != 3) {
        fprintf(stderr, "usage: %s NAME ENDPOINT, such as: %s settling " STURZ_DEFAULT_ENDPOINT "\n", argv[0], argv[0]);
        return EXIT_FAILURE;
    }
    sturz_simulation *simulation;
    must("connect", sturz_connect(argv[1], argv[2], 5.0, &simulation));
    /* Nobody else lets the time go on, and the run is paused when this program is lost. */
    must("lease", sturz_acquire_lease(simulation));

    const sturz_structured_mesh mesh = {.origin_m = {-WIDTH_M / 2, -WIDTH_M / 2, 0.0},
                                        .spacing_m = {WIDTH_M, WIDTH_M, HEIGHT_M / CELLS},
                                        .counts = {1, 1, CELLS}};
    sturz_fluid water = sturz_fluid_default();
    water.density_kg_per_m3 = DENSITY_KG_PER_M3;
    water.viscosity_pa_s = 1e-3;
    water.structured_mesh = &mesh;
    water.smoothing_length_m = 8e-3;
    water.drag = STURZ_DRAG_SCHILLER_NAUMANN;
    water.voidage = STURZ_VOIDAGE_NONE;
    water.buoyancy = 1; /* no hydrostatic pressure gradient among the fields */
    const sturz_fluid_fields fields = {.count = CELLS, .velocity_m_per_s = water_velocity};
    must("fluid", sturz_set_fluid(simulation, &water, &fields));

    double position[3], velocity[3];
    sturz_state ball = {.capacity = 1, .positions_m = position, .velocities_m_per_s = velocity};
    sturz_exchange exchange = {.capacity = CELLS,
                               .void_fraction = void_fraction,
                               .solid_velocity_m_per_s = solid_velocity,
                               .interaction_n_per_m3 = interaction};
    must("exchange", sturz_get_exchange(simulation, &exchange));
    for (int window = 1; window <= WINDOWS; window++) {
        const double momentum_before = exchange.momentum_kg_m_per_s[2];
        must("window", sturz_advance_with_fluid(simulation, WINDOW_S, &fields, &exchange, &ball, NULL));
        check_conservation(&exchange, momentum_before);
        solve_water();
        if (window % 20 == 0)
            printf("time %.3f s  height %.6f m  speed %.9f m/s\n", ball.time_s, position[2], -velocity[2]);
    }
    must("release", sturz_release_lease(simulation));
    sturz_close(simulation);
    return EXIT_SUCCESS;
}
