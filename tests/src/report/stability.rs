//! Stiff and extreme cases on one page: what is tried, what others do, and which cases of `validate` show what Sturz does.
//!
//! What others do is from measurements of November 2026 on the same kind of machine (Rockable 1.0.0-53, YADE 2023.02,
//! LAMMPS 2021 and 2025, rapier3d-f64 0.36.1, MuJoCo 4.0, parry3d-f64 0.31.1) and from the source papers; where nothing
//! was measured it says so.

/// A row of the table.
pub struct Extreme {
    /// Id in PHYSICS.md, section E.
    pub id: &'static str,
    /// What is tried.
    pub tried: &'static str,
    /// What others do.
    pub others: &'static str,
    /// What Sturz does, in words; the figures are those of the cases.
    pub here: &'static str,
    /// Cases that show it.
    pub cases: &'static [&'static str],
}

const NOT_MEASURED: &str = "not measured";

const fn row(
    id: &'static str,
    tried: &'static str,
    others: &'static str,
    here: &'static str,
    cases: &'static [&'static str],
) -> Extreme {
    Extreme { id, tried, others, here, cases }
}

/// S1 to S23.
pub const EXTREMES: &[Extreme] = &[
    row(
        "S1",
        "omega dt = .1, .5, 1, 1.9, 1.99 below, 2.01 and 2.1 above the limit",
        "the scheme itself: |lambda| = 1 at 2.00, 1.22 at 2.01",
        "bounded energy below; refused at start above, with the largest stable step",
        &["S1"],
    ),
    row(
        "S2",
        "stiffness ratio 1e6, mass ratio 1e6, heavy on light",
        NOT_MEASURED,
        "overlap of the light one as mg/k",
        &["S2"],
    ),
    row(
        "S3",
        "size ratio 1:100 and 1:1000",
        "a single grid costs cells by the cube of the ratio",
        "hierarchical grid: contacts as by all pairs, cost per particle as with equal sizes",
        &["S3", "S3-cost"],
    ),
    row(
        "S4",
        "needles and plates of 1:100",
        "parry: 0.1 to 4 % of exact or nearly exact contacts with a wrong normal; 52 to 98 % below 1e-4 length units",
        "none missed; depth and normal to rounding",
        &["S4", "S4L"],
    ),
    row(
        "S5",
        "towers of 10 and 50 cubes: aligned, offset by 1 %, leaning by 1e-3 rad",
        "10 cubes: Rockable 1.4e-2 J, tilted 0.57 J and never at rest; YADE 4.5e-3 J; rapier 0.2 J",
        "aligned at rest to rounding; those that lean sway, and the table has how much",
        &["TOWERS", "TOWER", "LAW3"],
    ),
    row(
        "S6",
        "exact face-face, parallel edges, vertex-vertex, coincident centres, identical pose",
        "parry: wrong normals in 0.1 to 4 %; Grains3D's single point spins a flat cylinder",
        "finite unit normals, the same in every repetition",
        &["S6"],
    ),
    row(
        "S7",
        "box whose centre of mass is .1, .3, .6 a off its middle",
        "topples wrongly under the largest overlap shared over N points (seed 000, eq. 3): no restoring torque",
        "rests below .5 a, topples above",
        &["S7"],
    ),
    row(
        "S8",
        "elastic frictionless cube, tilted by 2e-4 to 1.5e-2, 100 bounces",
        "largest overlap shared: up to +220 % of energy in one hit; mean over points: 40 %",
        "energy kept to the integrator's floor under the default law",
        &["S8"],
    ),
    row(
        "S9",
        "initial overlaps of 10, 50, 90 %",
        NOT_MEASURED,
        "bounded ejection or an error; [relax] takes them apart",
        &["S9"],
    ),
    row(
        "S10",
        "more than the thickness per step",
        NOT_MEASURED,
        "refused with the particle's id; less does not tunnel",
        &["S10"],
    ),
    row(
        "S11",
        "g = 0, mu = 0 and 1e12, e = 0 and 1, k_t = 0",
        NOT_MEASURED,
        "momentum to rounding, limits of the law",
        &["S11"],
    ),
    row("S12", "drum at 1000 rpm (Fr 55.9), gravity flips, tilt 0 to 180 deg", NOT_MEASURED, "nobody lost", &["S12"]),
    row(
        "S13",
        "all coordinates 1e6 and 1e8 sizes away",
        NOT_MEASURED,
        "with origin_m the same to the bit; else warned of or refused",
        &["S13"],
    ),
    row("S14", "contact across a corner of the cell, own image", NOT_MEASURED, "right, or a clear error", &["S14"]),
    row(
        "S15",
        "free rotation at |w| dt = .1 to 1.5, degenerate inertia",
        "symmetric splitting drifts by 5.7e-2 at 1.5",
        "energy to 1e-10, angular momentum to rounding",
        &["S15"],
    ),
    row(
        "S16",
        "5e6 steps of rest on a slope of 20 deg, with and without a tangential spring",
        "purely viscous friction (seed 000) and k_t = 0 (seed 001) creep at m g sin / gamma_t",
        "rests with a spring; without one it creeps at that very rate",
        &["S16", "S16L", "SLOPE"],
    ),
    row(
        "S17",
        "1,500 contacts on one particle",
        "sums with atomics differ from run to run",
        "the same bits on 1, 2 and 4 threads",
        &["S17"],
    ),
    row("S18", "no particles, one, all removed, no walls", NOT_MEASURED, "fields are zero, nothing is NaN", &["S18"]),
    row("S19", "NaN, infinite, negative numbers, zero quaternion", NOT_MEASURED, "refused with their path", &["S19"]),
    row("S20", "degenerate hulls", NOT_MEASURED, "typed errors, duplicates merged", &["S20"]),
    row("S21", "pinacoid whose ridge vanishes", NOT_MEASURED, "refused", &["S21"]),
    row(
        "S22",
        "commands during steps, duplicates, floods, slow subscribers",
        "zenoh with `Block` stalls a publisher by up to 837 ms beside a stuck subscriber",
        "atomic at steps, same trajectory: program `faults` (S22, HOSTILE, CROWD)",
        &[],
    ),
    row("S23", "restart from a checkpoint, tangential springs included", NOT_MEASURED, "the same bits", &["S23"]),
];
