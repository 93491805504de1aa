/* Sturz for C: particles of a Sturz daemon, coupled with a solver of one's own. docs/c.md explains it.
 *
 * Made of clients/c/src by cbindgen: change it there, and run the tests with STURZ_WRITE_HEADER=1.
 *
 * Rules for all functions:
 *  - They return STURZ_OK (0), or why not; sturz_last_error_message() has the sentence. They end no program and throw
 *    nothing.
 *  - Units are SI, and in the names. Arrays are of the caller, contiguous, with components of a row beside each other:
 *    (n, 3) stands for x0 y0 z0 x1 y1 z1 ...
 *  - Structs may be started from zeros (= {0}), which mean the defaults. What a struct points to is read or filled during the
 *    call, and not kept.
 *  - A handle may be used from several threads at once, each with arrays of its own. Calls block until the daemon has answered.
 *  - Texts are UTF-8 and end in a zero.
 *  - Null pointers where none is allowed, unknown enum values and lengths that do not fit are STURZ_INVALID_ARGUMENT. A
 *    handle that was closed, or an array shorter than its count says, cannot be noticed.
 */


#ifndef STURZ_H
#define STURZ_H

#include <stddef.h>
#include <stdint.h>

/* Where a daemon listens unless told otherwise. */
#define STURZ_DEFAULT_ENDPOINT "tcp/127.0.0.1:7447"


/**
 * What became of a call: 0 when it did what it says. `sturz_last_error_message` tells more of the others.
 */
typedef enum sturz_code {
    /**
     * Done.
     */
    STURZ_OK = 0,
    /**
     * An argument of this call is null, not finite, misaligned, of an unknown kind, or does not fit the others. Nothing was
     * sent.
     */
    STURZ_INVALID_ARGUMENT = 1,
    /**
     * An array of the caller has less room than there are rows; it is untouched, and the needed count is set. What else the
     * call does is done.
     */
    STURZ_TOO_SMALL = 2,
    /**
     * No daemon, or none of that name, was found within the time given.
     */
    STURZ_NOT_FOUND = 3,
    /**
     * The daemon was there, and is no more. Only `sturz_reconnect` goes on.
     */
    STURZ_GONE = 4,
    /**
     * No answer in time.
     */
    STURZ_TIMEOUT = 5,
    /**
     * This client may not do that: its certificate, or its role.
     */
    STURZ_DENIED = 6,
    /**
     * The window or the steps ended before their end: somebody paused or stopped the daemon, or the lease was lost.
     */
    STURZ_ENDED_EARLY = 7,
    /**
     * The answer lacks what was asked for: the fluid was taken away by somebody else.
     */
    STURZ_NOT_SENT = 8,
    /**
     * The answer cannot be read: the daemon is of another version.
     */
    STURZ_UNREADABLE = 9,
    /**
     * The message bus failed.
     */
    STURZ_BUS = 10,
    /**
     * A window was repeated as often as allowed, and has not converged.
     */
    STURZ_NOT_CONVERGED = 11,
    /**
     * A fault of this library.
     */
    STURZ_PANIC = 12,
    /**
     * Refused by the daemon, whose state is as it was; of a kind that this library does not know.
     */
    STURZ_REFUSED = 100,
    /**
     * The daemon could not read the request.
     */
    STURZ_REFUSED_UNDECODABLE = 101,
    /**
     * A value is missing, not finite, out of range or of the wrong length: `sturz_last_error_path` tells which.
     */
    STURZ_REFUSED_INVALID_INPUT = 102,
    /**
     * Over a limit of the daemon.
     */
    STURZ_REFUSED_TOO_LARGE = 103,
    /**
     * Its queue is full: try again.
     */
    STURZ_REFUSED_BUSY = 104,
    /**
     * Windows and steps need a paused simulation: `sturz_pause` first.
     */
    STURZ_REFUSED_NOT_PAUSED = 105,
    /**
     * Another window is under way.
     */
    STURZ_REFUSED_WINDOW_IN_FLIGHT = 106,
    /**
     * The simulation is not where this client left it: somebody else went on. `sturz_get_info` takes note of where it is.
     */
    STURZ_REFUSED_WRONG_TIME = 107,
    /**
     * The request id was used before.
     */
    STURZ_REFUSED_REQUEST_ID_REUSED = 108,
    /**
     * There is no checkpoint, or no fluid with a mesh.
     */
    STURZ_REFUSED_NOT_FOUND = 109,
    /**
     * The run has failed, and can only be read or restored.
     */
    STURZ_REFUSED_RUN_FAILED = 110,
    /**
     * The daemon is ending.
     */
    STURZ_REFUSED_STOPPING = 111,
    /**
     * A fault of the daemon.
     */
    STURZ_REFUSED_INTERNAL = 112,
    /**
     * The checkpoint is damaged, of another scene or of another version.
     */
    STURZ_REFUSED_UNUSABLE_CHECKPOINT = 113,
    /**
     * The daemon's disk is full, or refuses.
     */
    STURZ_REFUSED_DISK = 114,
    /**
     * Another client holds the lease, or this one does not.
     */
    STURZ_REFUSED_LEASE = 115,
    /**
     * A recording is played there: it cannot be steered.
     */
    STURZ_REFUSED_RECORDING = 116,
} sturz_code;

/**
 * What a simulation does.
 */
typedef enum sturz_run_state {
    /**
     * Of a daemon newer than this library.
     */
    STURZ_RUN_STATE_UNKNOWN = 0,
    /**
     * Steps freely.
     */
    STURZ_RUN_STATE_RUNNING = 1,
    /**
     * Waits for commands.
     */
    STURZ_RUN_STATE_PAUSED = 2,
    /**
     * Inside a window.
     */
    STURZ_RUN_STATE_ADVANCING = 3,
    /**
     * A step was refused: it can be read and restored, not advanced.
     */
    STURZ_RUN_STATE_FAILED = 4,
    /**
     * The daemon is going.
     */
    STURZ_RUN_STATE_ENDED = 5,
} sturz_run_state;

/**
 * Why a window or steps ended.
 */
typedef enum sturz_stop_reason {
    /**
     * Of a daemon newer than this library.
     */
    STURZ_STOP_REASON_UNKNOWN = 0,
    /**
     * All steps are done.
     */
    STURZ_STOP_REASON_COMPLETE = 1,
    /**
     * Somebody paused.
     */
    STURZ_STOP_REASON_PAUSED = 2,
    /**
     * The daemon ends.
     */
    STURZ_STOP_REASON_STOPPED = 3,
    /**
     * The holder of the lease was lost.
     */
    STURZ_STOP_REASON_LEASE_LOST = 4,
} sturz_stop_reason;

/**
 * Drag of one particle in a fluid without others, as docs/hydrodynamics.md has it.
 */
typedef enum sturz_drag {
    /**
     * Haider and Levenspiel.
     */
    STURZ_DRAG_DEFAULT = 0,
    /**
     * No drag.
     */
    STURZ_DRAG_NONE = 1,
    /**
     * 3 pi mu d, for Reynolds numbers below 0.1.
     */
    STURZ_DRAG_STOKES = 2,
    /**
     * Schiller and Naumann 1935: spheres.
     */
    STURZ_DRAG_SCHILLER_NAUMANN = 3,
    /**
     * Haider and Levenspiel 1989: by sphericity.
     */
    STURZ_DRAG_HAIDER_LEVENSPIEL = 4,
    /**
     * Ganser 1993: by sphericity.
     */
    STURZ_DRAG_GANSER = 5,
    /**
     * Hoelzer and Sommerfeld 2008: by orientation.
     */
    STURZ_DRAG_HOLZER_SOMMERFELD = 6,
} sturz_drag;

/**
 * How the drag changes among other particles.
 */
typedef enum sturz_voidage {
    /**
     * Di Felice.
     */
    STURZ_VOIDAGE_DEFAULT = 0,
    /**
     * Not at all.
     */
    STURZ_VOIDAGE_NONE = 1,
    /**
     * Di Felice 1994: a factor of the law of one particle.
     */
    STURZ_VOIDAGE_DI_FELICE = 2,
    /**
     * Gidaspow 1994: Ergun's law in beds, Wen and Yu's above; instead of the law of one particle.
     */
    STURZ_VOIDAGE_GIDASPOW = 3,
    /**
     * Tenneti, Garg and Subramaniam 2011.
     */
    STURZ_VOIDAGE_TENNETI = 4,
    /**
     * Beetstra, van der Hoef and Kuipers 2007; instead of the law of one particle.
     */
    STURZ_VOIDAGE_BEETSTRA = 5,
} sturz_voidage;

/**
 * Force across the flow.
 */
typedef enum sturz_lift {
    /**
     * None.
     */
    STURZ_LIFT_NONE = 0,
    /**
     * Saffman 1965 with Mei 1992: spheres in shear; needs the vorticity.
     */
    STURZ_LIFT_SAFFMAN_MEI = 1,
    /**
     * Hoerner 1965: bodies with an axis, by their angle to the flow.
     */
    STURZ_LIFT_CROSS_FLOW = 2,
} sturz_lift;

/**
 * Torque by drag that acts beside the centre of mass.
 */
typedef enum sturz_pitching {
    /**
     * None.
     */
    STURZ_PITCHING_NONE = 0,
    /**
     * Rosendahl 2000: bodies with an axis.
     */
    STURZ_PITCHING_ROSENDAHL = 1,
} sturz_pitching;

/**
 * Torque against spin.
 */
typedef enum sturz_rotational_drag {
    /**
     * None.
     */
    STURZ_ROTATIONAL_DRAG_NONE = 0,
    /**
     * pi mu d^3.
     */
    STURZ_ROTATIONAL_DRAG_STOKES = 1,
    /**
     * Dennis, Singh and Ingham 1980.
     */
    STURZ_ROTATIONAL_DRAG_DENNIS = 2,
} sturz_rotational_drag;

/**
 * What a structured mesh ends in.
 */
typedef enum sturz_mesh_side {
    /**
     * Closed.
     */
    STURZ_MESH_SIDE_DEFAULT = 0,
    /**
     * A wall: what is spread beyond it counts inside, mirrored.
     */
    STURZ_MESH_SIDE_CLOSED = 1,
    /**
     * Fluid ends there: particles are in it as far as they are inside.
     */
    STURZ_MESH_SIDE_OPEN = 2,
    /**
     * What leaves comes in at the other end; at both ends of an axis or at none.
     */
    STURZ_MESH_SIDE_PERIODIC = 3,
} sturz_mesh_side;

/**
 * A participant of a coupled run. From `sturz_participant_initialize`, for `sturz_participant_finalize`.
 */
typedef struct sturz_participant sturz_participant;

/**
 * A connected simulation. From `sturz_connect`, for `sturz_close`.
 */
typedef struct sturz_simulation sturz_simulation;

/**
 * Where a simulation stands.
 */
typedef struct sturz_info {
    /**
     * Simulated time, s.
     */
    double time_s;
    /**
     * Nominal time step, s.
     */
    double time_step_s;
    /**
     * Acceleration of gravity, m/s2.
     */
    double gravity_m_per_s2[3];
    /**
     * Steps done.
     */
    uint64_t step;
    /**
     * Particles present.
     */
    uint64_t particles;
    /**
     * Counts insertions and removals: ids asked for in one epoch are those of the particles while it lasts.
     */
    uint64_t topology_epoch;
    /**
     * Of the whole state: equal where two runs are equal to the bit.
     */
    uint64_t state_hash;
    /**
     * What it does.
     */
    enum sturz_run_state state;
} sturz_info;

/**
 * Particles at one moment: arrays of the caller with a row per particle, in ascending order of ids. Set `capacity` and the
 * arrays that are wanted; the others stay null. With all of them null the rest alone is set: to learn how much room is needed.
 */
typedef struct sturz_state {
    /**
     * Rows that each of the arrays has room for.
     */
    uint64_t capacity;
    /**
     * (n): never used again for others.
     */
    uint64_t *ids;
    /**
     * (n, 3): centres of mass, wrapped into the periodic cell, m.
     */
    double *positions_m;
    /**
     * (n, 4): unit quaternions, world from body, as w, x, y, z.
     */
    double *orientations_wxyz;
    /**
     * (n, 3): of the centres of mass, m/s.
     */
    double *velocities_m_per_s;
    /**
     * (n, 3): world axes, rad/s.
     */
    double *angular_velocities_rad_per_s;
    /**
     * Set: n, the particles there are, also where the capacity is less.
     */
    uint64_t count;
    /**
     * Set: simulated time, s.
     */
    double time_s;
    /**
     * Set: steps done.
     */
    uint64_t step;
    /**
     * Set: of the ids, for `sturz_loads`.
     */
    uint64_t topology_epoch;
} sturz_state;

/**
 * Equal boxes. Values are means over a cell; x runs fastest: i + counts[0] * (j + counts[1] * k).
 */
typedef struct sturz_structured_mesh {
    /**
     * Lowest corner, m.
     */
    double origin_m[3];
    /**
     * Sides of a cell, above 0, m.
     */
    double spacing_m[3];
    /**
     * Cells along each axis, at least 1.
     */
    uint32_t counts[3];
    /**
     * What each axis ends in at its low end: `enum sturz_mesh_side`.
     */
    int32_t low_sides[3];
    /**
     * What each axis ends in at its high end.
     */
    int32_t high_sides[3];
} sturz_structured_mesh;

/**
 * Centres of the cells of any mesh, or its nodes. A particle further than the smoothing length from all is outside.
 */
typedef struct sturz_point_mesh {
    /**
     * n.
     */
    uint64_t count;
    /**
     * (n, 3), m.
     */
    const double *points_m;
    /**
     * (n): volume that belongs to each, above 0, m3.
     */
    const double *volumes_m3;
} sturz_point_mesh;

/**
 * A fluid for the particles to be in; docs/coupling.md has the equations. Start from zeros or from `sturz_fluid_default`,
 * and set density, viscosity and, for a solver, a mesh and the smoothing length.
 */
typedef struct sturz_fluid {
    /**
     * Above 0, kg/m3.
     */
    double density_kg_per_m3;
    /**
     * Dynamic, above 0, Pa s.
     */
    double viscosity_pa_s;
    /**
     * Everywhere, until fields come; without a mesh for good, m/s.
     */
    double velocity_m_per_s[3];
    /**
     * Where its values are: one of the two meshes. Both null: the same everywhere, and nobody answers for it.
     */
    const struct sturz_structured_mesh *structured_mesh;
    /**
     * Instead of the structured one.
     */
    const struct sturz_point_mesh *point_mesh;
    /**
     * Half-width of the kernel that spreads particles over the mesh, above 0 with a mesh and 0 without one, m. Two to three
     * particle diameters are usual.
     */
    double smoothing_length_m;
    /**
     * Without a mesh: void fraction that the laws see, in (0, 1]. 0 means 1.
     */
    double void_fraction;
    /**
     * The laws see no void fraction below this, in (0, 1]. 0 means 0.2.
     */
    double least_void_fraction;
    /**
     * `enum sturz_drag`.
     */
    int32_t drag;
    /**
     * `enum sturz_voidage`.
     */
    int32_t voidage;
    /**
     * `enum sturz_lift`.
     */
    int32_t lift;
    /**
     * `enum sturz_pitching`.
     */
    int32_t pitching;
    /**
     * `enum sturz_rotational_drag`.
     */
    int32_t rotational_drag;
    /**
     * Not 0 adds -density volume gravity: for a fluid whose pressure leaves the hydrostatic part out.
     */
    int32_t buoyancy;
    /**
     * Added mass over the mass of the fluid displaced, at least 0: 1/2 for a sphere.
     */
    double added_mass_coefficient;
    /**
     * Steps between two looks at where the particles are in the mesh. 0: at the start of each window, and whenever one may
     * have come further than a tenth of the smoothing length.
     */
    uint64_t refresh_steps;
} sturz_fluid;

/**
 * The fluid on its mesh: arrays with a row per cell or point, or null: 0 for all.
 */
typedef struct sturz_fluid_fields {
    /**
     * n, cells or points of the mesh.
     */
    uint64_t count;
    /**
     * (n, 3): between the particles, not averaged over the cell with them, m/s.
     */
    const double *velocity_m_per_s;
    /**
     * (n, 3), Pa/m.
     */
    const double *pressure_gradient_pa_per_m;
    /**
     * (n, 3): material derivative of the velocity, for the added mass, m/s2.
     */
    const double *acceleration_m_per_s2;
    /**
     * (n, 3): curl of the velocity, for lift and rotation, rad/s.
     */
    const double *vorticity_rad_per_s;
    /**
     * The fields before change linearly into these over this time, s: the window, for fields of its end. 0: at once.
     */
    double ramp_s;
} sturz_fluid_fields;

/**
 * What the fluid gets from the particles: arrays of the caller with a row per cell or point of its mesh, and totals. Set
 * `capacity` and the arrays that are wanted; the others stay null. Forces are means from `from_time_s` to `time_s`.
 */
typedef struct sturz_exchange {
    /**
     * Rows that each of the arrays has room for.
     */
    uint64_t capacity;
    /**
     * (n): 1 less the part of the cell that particles fill, at the end.
     */
    double *void_fraction;
    /**
     * (n, 3): mean over the solid in the cell, at the end, m/s; 0 where there is none.
     */
    double *solid_velocity_m_per_s;
    /**
     * (n, 3): force on the fluid by drag, lift and added mass over the volume of the cell, N/m3.
     */
    double *interaction_n_per_m3;
    /**
     * (n, 3): force on the particles by the given pressure gradient, likewise, N/m3.
     */
    double *pressure_force_n_per_m3;
    /**
     * (n): by how much the interaction opposes a change of the fluid's velocity, kg/(m3 s).
     */
    double *drag_kg_per_m3_s;
    /**
     * Set: n, cells or points of the mesh, also where the capacity is less.
     */
    uint64_t cells;
    /**
     * Set: since when forces are counted, the start of the window, s.
     */
    double from_time_s;
    /**
     * Set: simulated time, s.
     */
    double time_s;
    /**
     * Set: volume of all particles, m3.
     */
    double solid_volume_m3;
    /**
     * Set: of it, in the mesh.
     */
    double immersed_volume_m3;
    /**
     * Set: particles that are wholly outside of the mesh.
     */
    uint64_t outside;
    /**
     * Set: looks at where the particles are in the mesh, since the fluid was defined.
     */
    uint64_t refreshes;
    /**
     * Set: on the fluid by drag, lift and added mass, N s.
     */
    double impulse_on_fluid_n_s[3];
    /**
     * Set: on the particles by the given pressure gradient, N s.
     */
    double pressure_impulse_n_s[3];
    /**
     * Set: on the particles by buoyancy, N s.
     */
    double buoyancy_impulse_n_s[3];
    /**
     * Set: of the particles that move freely, at the end, kg m/s.
     */
    double momentum_kg_m_per_s[3];
} sturz_exchange;

/**
 * Loads from outside. On a particle of velocity v and angular velocity w act the force f + K (u - v) and the torque
 * t + L (q - w), however large K and L are. Each array has a row per id, or is null: 0 for all.
 */
typedef struct sturz_loads {
    /**
     * Of the state that the ids are from (`sturz_state`); with another one than the present they are refused.
     */
    uint64_t topology_epoch;
    /**
     * n, the ids; 0 for no loads.
     */
    uint64_t count;
    /**
     * (n): each once, in any order.
     */
    const uint64_t *ids;
    /**
     * f, (n, 3), N.
     */
    const double *force_n;
    /**
     * t, (n, 3), world axes, N m.
     */
    const double *torque_n_m;
    /**
     * K, (n), at least 0, N s/m.
     */
    const double *drag_n_s_per_m;
    /**
     * u, (n, 3), m/s.
     */
    const double *fluid_velocity_m_per_s;
    /**
     * L, (n), at least 0, N m s.
     */
    const double *rotational_drag_n_m_s;
    /**
     * q, (n, 3), world axes, rad/s.
     */
    const double *fluid_angular_velocity_rad_per_s;
    /**
     * The loads before change linearly into these over this time, s. 0: at once.
     */
    double ramp_s;
    /**
     * Simulated time until which they act, s. 0: without end.
     */
    double valid_until_s;
} sturz_loads;

/**
 * What became of a window or of steps.
 */
typedef struct sturz_advanced {
    /**
     * Simulated time now, s.
     */
    double time_s;
    /**
     * Steps done by the state now.
     */
    uint64_t step;
    /**
     * Of this window.
     */
    uint64_t steps_done;
    /**
     * All done, or ended early.
     */
    enum sturz_stop_reason stop_reason;
} sturz_advanced;

/**
 * How a coupled run marches.
 */
typedef struct sturz_coupling {
    /**
     * Length of a window, above 0, s. The last one may be shorter.
     */
    double window_s;
    /**
     * Simulated time of the end, s. 0: without end.
     */
    double end_time_s;
    /**
     * 0: each window once (explicit). Above: a window is repeated until the fields of the fluid change from one iteration to
     * the next by no more than this, relative to the last ones, for each of their columns (implicit).
     */
    double tolerance;
    /**
     * Of an implicit window, at least 2. 0 means 50.
     */
    uint32_t max_iterations;
} sturz_coupling;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * What the last call of this thread that failed returned; `STURZ_OK` when none has.
 */
enum sturz_code sturz_last_error_code(void);

/**
 * Why the last call of this thread that failed did so, as a sentence in UTF-8: what is wrong and what would be right. Empty
 * when none has failed. Valid until the next call of this thread that fails.
 */
const char *sturz_last_error_message(void);

/**
 * What it was about, such as `loads.force_n[1]`; empty when it was about the whole. Valid as the message is.
 */
const char *sturz_last_error_path(void);

/**
 * Version of this library, such as "0.1.0". Lives as long as the program.
 */
const char *sturz_version(void);

/**
 * Connects to the daemon that serves the simulation `name` at `endpoint`, such as "tcp/127.0.0.1:7447"
 * (`STURZ_DEFAULT_ENDPOINT`; null means the same), within `timeout_s` seconds. Sets `*simulation`, to null on failure.
 */
enum sturz_code sturz_connect(const char *name,
                              const char *endpoint,
                              double timeout_s,
                              struct sturz_simulation **simulation);

/**
 * The same for a daemon that wants a certificate, such as at "tls/host:7447": `folder` is that of one client as
 * `sturz certs` makes it, with ca.pem, certificate.pem and key.pem.
 */
enum sturz_code sturz_connect_tls(const char *name,
                                  const char *endpoint,
                                  const char *folder,
                                  double timeout_s,
                                  struct sturz_simulation **simulation);

/**
 * Connects anew after `STURZ_GONE`, as the same client, within `timeout_s` seconds. The lease must be acquired again.
 * The daemon may be another one: compare `sturz_get_info` with what was known. Until it succeeds the handle stays as it is.
 */
enum sturz_code sturz_reconnect(struct sturz_simulation *simulation,
                                double timeout_s);

/**
 * Ends the connection and frees the handle; null is nothing to do. The daemon goes on living, and is paused if this client
 * had the lease. No other call may use the handle meanwhile or afterwards.
 */
void sturz_close(struct sturz_simulation *simulation);

/**
 * Where the simulation stands. The next window starts there.
 */
enum sturz_code sturz_get_info(const struct sturz_simulation *simulation, struct sturz_info *info);

/**
 * Makes this client the only one that may advance, step, resume, restore, set loads and set the fluid, until
 * `sturz_release_lease` or `sturz_close`. When its connection is lost the run is paused.
 */
enum sturz_code sturz_acquire_lease(const struct sturz_simulation *simulation);

/**
 * Lets others advance again.
 */
enum sturz_code sturz_release_lease(const struct sturz_simulation *simulation);

/**
 * Sets the acceleration of gravity, m/s2, three numbers.
 */
enum sturz_code sturz_set_gravity(const struct sturz_simulation *simulation, const double *gravity_m_per_s2);

/**
 * Stops stepping. A window of another thread or client ends early by it.
 */
enum sturz_code sturz_pause(const struct sturz_simulation *simulation);

/**
 * Lets the simulation step freely, until `sturz_pause`. Windows and steps are refused meanwhile.
 */
enum sturz_code sturz_resume(const struct sturz_simulation *simulation);

/**
 * Ends the daemon, and waits until it is gone. The handle must still be closed.
 */
enum sturz_code sturz_stop(const struct sturz_simulation *simulation);

/**
 * Saves the whole state under a name, in the daemon's memory or, where `on_disk` is not 0, as a file that outlives it (the
 * daemon must have a folder for them: `--checkpoints`). One of that name is replaced.
 */
enum sturz_code sturz_checkpoint(const struct sturz_simulation *simulation,
                                 const char *token,
                                 int32_t on_disk);

/**
 * Goes to a saved state, bit for bit; a run that has failed is paused by it. The next window starts there.
 */
enum sturz_code sturz_restore(const struct sturz_simulation *simulation, const char *token);

/**
 * Forgets a saved state, its file included.
 */
enum sturz_code sturz_drop_checkpoint(const struct sturz_simulation *simulation, const char *token);

/**
 * The particles now.
 */
enum sturz_code sturz_get_state(const struct sturz_simulation *simulation, struct sturz_state *state);

/**
 * A fluid with the usual laws written out (Haider and Levenspiel's drag, Di Felice's factor; no lift, no torques, no added
 * mass, no buoyancy), without density, viscosity and mesh, which have no default. Zeros mean the same.
 */
struct sturz_fluid sturz_fluid_default(void);

/**
 * Puts a fluid around the particles, instead of the one before, with fields on its mesh; null for `fields`: the fluid's
 * velocity everywhere. Fields need a mesh.
 */
enum sturz_code sturz_set_fluid(const struct sturz_simulation *simulation,
                                const struct sturz_fluid *fluid,
                                const struct sturz_fluid_fields *fields);

/**
 * Takes the fluid away.
 */
enum sturz_code sturz_remove_fluid(const struct sturz_simulation *simulation);

/**
 * What the fluid gets from the particles, now; refused where there is no fluid with a mesh.
 */
enum sturz_code sturz_get_exchange(const struct sturz_simulation *simulation,
                                   struct sturz_exchange *exchange);

/**
 * Replaces all loads from now on, until others come. `count` 0 takes them away.
 */
enum sturz_code sturz_set_loads(const struct sturz_simulation *simulation, const struct sturz_loads *loads);

/**
 * Advances by exactly one window of `window_s` seconds of simulated time: as many equal steps as it takes, none longer than
 * the nominal one. Fluid and loads of before go on. Fills `exchange`, `state` and `done` at its end; each may be null.
 *
 * The simulation must be paused, and where this client knows it to be (`STURZ_REFUSED_WRONG_TIME` otherwise). After
 * `STURZ_TOO_SMALL` and `STURZ_NOT_SENT` the window is done, and `sturz_get_state` and `sturz_get_exchange` can be asked;
 * after `STURZ_ENDED_EARLY` what was asked for is that of the time in `done`. A refused window leaves the particles where they
 * were; after a lost connection `sturz_get_info` tells where they are.
 */
enum sturz_code sturz_advance(const struct sturz_simulation *simulation,
                              double window_s,
                              struct sturz_exchange *exchange,
                              struct sturz_state *state,
                              struct sturz_advanced *done);

/**
 * The same in other fields of the fluid from its start on, instead of those before. Room for the exchange must be that for
 * `fields->count` rows. Where the fields are refused, so is the window.
 */
enum sturz_code sturz_advance_with_fluid(const struct sturz_simulation *simulation,
                                         double window_s,
                                         const struct sturz_fluid_fields *fields,
                                         struct sturz_exchange *exchange,
                                         struct sturz_state *state,
                                         struct sturz_advanced *done);

/**
 * The same with other loads on single particles from its start on, instead of those before: for a solver that finds the
 * forces itself. Where they are refused, so is the window.
 */
enum sturz_code sturz_advance_with_loads(const struct sturz_simulation *simulation,
                                         double window_s,
                                         const struct sturz_loads *loads,
                                         struct sturz_state *state,
                                         struct sturz_advanced *done);

/**
 * Does `steps` steps of the nominal time step; `done` may be null. The simulation must be paused.
 */
enum sturz_code sturz_step(const struct sturz_simulation *simulation,
                           uint64_t steps,
                           struct sturz_advanced *done);

/**
 * Takes the lease, fills `exchange` (may be null) with what the fluid gets at the start, and sets `*participant`, to null on
 * failure. The simulation must be paused and have a fluid with a mesh. The participant has the connection for itself: the
 * handle may be closed before it is finalized. Its calls from several threads wait for each other.
 *
 * Each turn of the coupled run then is: the solver saves itself where `sturz_participant_requires_writing_checkpoint` says
 * so, goes to the end of a window of `sturz_participant_window_s`, and hands its fields to `sturz_participant_advance`; where
 * `sturz_participant_requires_reading_checkpoint` says so, it goes back to what it saved and does the window again.
 */
enum sturz_code sturz_participant_initialize(const struct sturz_simulation *simulation,
                                             const struct sturz_coupling *coupling,
                                             struct sturz_exchange *exchange,
                                             struct sturz_participant **participant);

/**
 * Goes to the end of the window with the particles in these fields, and fills `exchange` (may be null) there.
 * `fields->ramp_s` says whether they hold from the start (0) or are those of the end (the window). After
 * `STURZ_NOT_CONVERGED` the particles are at the start of the window.
 */
enum sturz_code sturz_participant_advance(const struct sturz_participant *participant,
                                          const struct sturz_fluid_fields *fields,
                                          struct sturz_exchange *exchange);

/**
 * Whether there is a window to do: 1 or 0; -1 where `participant` is null, as for all questions.
 */
int32_t sturz_participant_is_coupling_ongoing(const struct sturz_participant *participant);

/**
 * Whether the last `sturz_participant_advance` has ended a window for good.
 */
int32_t sturz_participant_is_time_window_complete(const struct sturz_participant *participant);

/**
 * Whether the solver must save itself now: a window starts that may be repeated.
 */
int32_t sturz_participant_requires_writing_checkpoint(const struct sturz_participant *participant);

/**
 * Whether the solver must go back to the start of the window: it is repeated.
 */
int32_t sturz_participant_requires_reading_checkpoint(const struct sturz_participant *participant);

/**
 * Length of the window under way, s: shorter at the end. -1 where `participant` is null.
 */
double sturz_participant_window_s(const struct sturz_participant *participant);

/**
 * Where the window under way starts, simulated time, s. -1 where `participant` is null.
 */
double sturz_participant_time_s(const struct sturz_participant *participant);

/**
 * Gives the lease back and frees the participant, also where it fails; null is nothing to do. The particles stay where they
 * are. No other call may use the participant meanwhile or afterwards.
 */
enum sturz_code sturz_participant_finalize(struct sturz_participant *participant);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* STURZ_H */
