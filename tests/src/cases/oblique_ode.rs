//! Reference for oblique impacts: the equations of motion of a ball at a wall, by Runge-Kutta of order 4, with every
//! change between stick and slip and the end of the contact found to rounding.

/// Normal force with overlap d and approach speed v.
#[derive(Clone, Copy)]
pub enum Normal {
    /// k d + c v.
    Linear { stiffness: f64, damping: f64 },
    /// k d^1.5 + c d^(1/4) v.
    Hertz { stiffness: f64, damping: f64 },
}

/// Tangential force that friction limits.
#[derive(Clone, Copy)]
pub enum Tangent {
    /// Spring, N/m.
    Spring(f64),
    /// Dashpot, N s/m.
    Dashpot(f64),
    /// Spring of coefficient x sqrt(d), N/m^1.5: keeps its force while the overlap grows, its stretch while it falls.
    Mindlin(f64),
}

/// A ball without spin before it hits a wall; the contact acts until the overlap is zero.
pub struct Impact {
    pub mass: f64,
    pub radius: f64,
    pub normal: Normal,
    pub tangent: Tangent,
    pub friction: f64,
    pub step_s: f64,
}

/// After an impact.
pub struct After {
    /// Speed along the wall, m/s.
    pub along: f64,
    /// About the axis that rolling on turns about, rad/s.
    pub spin: f64,
}

/// Overlap, its rate, speed along the wall, spin, force of the tangential spring (against the motion).
type State = [f64; 5];

/// What the tangential force does.
#[derive(Clone, Copy, PartialEq)]
enum Mode {
    /// The law's own.
    Stick,
    /// mu times the normal force, with this sign.
    Slip(f64),
}

impl Normal {
    /// Force, and its rate with the rate of `v`.
    fn force(&self, d: f64, v: f64, rate_of_v: impl Fn(f64) -> f64) -> (f64, f64) {
        let d = d.max(f64::MIN_POSITIVE);
        match *self {
            Self::Linear { stiffness, damping } => {
                let force = stiffness * d + damping * v;
                (force, stiffness * v + damping * rate_of_v(force))
            }
            Self::Hertz { stiffness, damping } => {
                let (half, quarter) = (d.sqrt(), d.powf(0.25));
                let force = stiffness * d * half + damping * quarter * v;
                let rate =
                    1.5 * stiffness * half * v + damping * (0.25 * quarter / d * v * v + quarter * rate_of_v(force));
                (force, rate)
            }
        }
    }
}

impl Impact {
    /// Friction acts while the normal force presses.
    fn limit(&self, y: &State) -> f64 {
        self.friction * self.normal.force(y[0], y[1], |_| 0.0).0.max(0.0)
    }

    /// Speed of the surface: halfway between the surfaces, as the engine has its points.
    fn slip(&self, y: &State) -> f64 {
        y[2] - y[3] * self.arm(y)
    }

    fn arm(&self, y: &State) -> f64 {
        self.radius - 0.5 * y[0]
    }

    /// Rate of the spring's force while it sticks, from a force f.
    fn spring_rate(&self, y: &State, f: f64) -> f64 {
        match self.tangent {
            Tangent::Spring(stiffness) => stiffness * self.slip(y),
            Tangent::Dashpot(_) => 0.0,
            Tangent::Mindlin(coefficient) => {
                let d = y[0].max(f64::MIN_POSITIVE);
                // unloading: f = x sqrt(d) xi at a given stretch
                coefficient * d.sqrt() * self.slip(y) + if y[1] < 0.0 { 0.5 * f * y[1] / d } else { 0.0 }
            }
        }
    }

    /// Tangential force against the motion.
    fn tangential(&self, y: &State, mode: Mode) -> f64 {
        match (mode, self.tangent) {
            (Mode::Slip(sign), _) => sign * self.limit(y),
            (Mode::Stick, Tangent::Dashpot(damping)) => damping * self.slip(y),
            (Mode::Stick, _) => y[4],
        }
    }

    fn slope(&self, y: &State, mode: Mode) -> State {
        let normal = self.normal.force(y[0], y[1], |_| 0.0).0;
        let along = self.tangential(y, mode);
        let inertia = 0.4 * self.mass * self.radius * self.radius;
        let spring = if mode == Mode::Stick { self.spring_rate(y, y[4]) } else { 0.0 };
        [y[1], -normal / self.mass, -along / self.mass, along * self.arm(y) / inertia, spring]
    }

    fn ahead(&self, y: &State, mode: Mode, h: f64) -> State {
        let moved = |k: &State, h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
        let a = self.slope(y, mode);
        let b = self.slope(&moved(&a, 0.5 * h), mode);
        let c = self.slope(&moved(&b, 0.5 * h), mode);
        let d = self.slope(&moved(&c, h), mode);
        std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]))
    }

    /// Positive once the mode is over.
    fn excess(&self, y: &State, mode: Mode) -> f64 {
        match (mode, self.tangent) {
            (Mode::Stick, _) => self.tangential(y, mode).abs() - self.limit(y),
            (Mode::Slip(_), Tangent::Dashpot(damping)) => self.limit(y) - damping * self.slip(y).abs(),
            // it sticks again where the spring would grow more slowly than the limit
            (Mode::Slip(sign), _) => {
                let (force, rate) = self.normal.force(y[0], y[1], |force| -force / self.mass);
                let limit_rate = if force > 0.0 { self.friction * rate } else { 0.0 };
                limit_rate - sign * self.spring_rate(y, sign * self.limit(y))
            }
        }
    }

    fn changed(&self, y: &mut State, mode: Mode) -> Mode {
        match mode {
            Mode::Stick => Mode::Slip(self.tangential(y, mode).signum()),
            Mode::Slip(sign) => {
                y[4] = sign * self.limit(y);
                Mode::Stick
            }
        }
    }

    /// The ball after it has hit the wall with these speeds.
    pub fn rebound(&self, approach: f64, along: f64) -> After {
        let (mut y, mut mode) = ([0.0, approach, along, 0.0, 0.0], Mode::Stick);
        if self.excess(&y, mode) > 0.0 {
            mode = self.changed(&mut y, mode);
        }
        loop {
            let over = |y: &State| y[0] < 0.0 || self.excess(y, mode) > 0.0;
            let after = self.ahead(&y, mode, self.step_s);
            if !over(&after) {
                y = after;
                continue;
            }
            let (mut low, mut high) = (0.0, self.step_s);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if over(&self.ahead(&y, mode, middle)) { high = middle } else { low = middle }
            }
            y = self.ahead(&y, mode, high);
            if y[0] < 0.0 {
                return After { along: y[2], spin: y[3] };
            }
            mode = self.changed(&mut y, mode);
        }
    }
}
