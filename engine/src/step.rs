//! One step, to be read aloud: velocity Verlet with one force evaluation, at the end of the step.

use crate::engine::Engine;
use crate::error::StepError;
use crate::timing::Stage;

impl Engine {
    /// The stages of one step, in order. What the scene does not need is empty inside them.
    pub(crate) fn step_stages(&mut self) -> Result<(), StepError> {
        self.begin_timing();

        // From step n to n+1: positions first, with the forces of step n.
        self.load_first_half();
        self.half_kick_and_drift();
        self.unload_first_half();
        self.wrap_into_cell();
        self.drive_servos();
        self.move_boundaries();
        self.lap(Stage::Drift);

        self.rebuild_neighbours_if_stale(self.clock.time_after_s(1));
        self.lap(Stage::Neighbours);

        // Contact geometry at n+1, with the tangential springs of n.
        self.find_contacts();
        self.lap(Stage::Narrow);

        // Forces at n+1, with velocities predicted there.
        self.evaluate_forces();
        self.lap(Stage::Forces);

        self.gather_forces();
        self.book_frozen_work();
        self.damp_locally(self.clock.time_step_s());
        self.lap(Stage::Gather);

        self.load_second_half();
        self.half_kick();
        self.unload();
        self.advance_clock();
        let outcome = self.guard();
        self.lap(Stage::Kick);
        outcome
    }
}
