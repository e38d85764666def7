//! Exact steady state of one mode with a Jenkins element: closed-form motion between events, events by
//! bisection, marched until periodic.

/// `q̈ + 2ζωq̇ + ω²q + lever·T = force·cos(frequency·t)`, `u = lever·q`.
pub struct Oscillator {
    pub natural: f64,
    pub damping_ratio: f64,
    pub lever: f64,
    pub stiffness: f64,
    pub limit: f64,
    pub force: f64,
    pub frequency: f64,
}

/// What one period of the steady state has.
pub struct SteadyPeriod {
    /// Largest |q|.
    pub amplitude: f64,
    /// Limit times slip distance (J).
    pub dissipated_energy: f64,
}

/// Displacement and velocity after `t` of `q̈ + 2dq̇ + Kq = constant + force·cos(Ω(t0 + t))`.
fn motion(o: &Oscillator, stiffness: f64, constant: f64, t0: f64, start: (f64, f64), t: f64) -> (f64, f64) {
    let d = o.damping_ratio * o.natural;
    let (real, imaginary) = (stiffness - o.frequency * o.frequency, 2.0 * d * o.frequency);
    let size = o.force / (real * real + imaginary * imaginary);
    let forced = |time: f64| {
        let (sin, cos) = (o.frequency * time).sin_cos();
        let q = constant / stiffness + size * (real * cos + imaginary * sin);
        (q, size * o.frequency * (-real * sin + imaginary * cos))
    };
    let (q0, v0) = forced(t0);
    let (a, b) = (start.0 - q0, start.1 - v0);
    let w = (stiffness - d * d).sqrt();
    let (sin, cos) = (w * t).sin_cos();
    let decay = (-d * t).exp();
    let c = (b + d * a) / w;
    let (q, v) = forced(t0 + t);
    (q + decay * (a * cos + c * sin), v + decay * ((c * w - d * a) * cos - (a * w + d * c) * sin))
}

pub fn steady_period(o: &Oscillator) -> SteadyPeriod {
    let period = std::f64::consts::TAU / o.frequency;
    let stick = o.natural * o.natural + o.lever * o.lever * o.stiffness;
    let slip = o.natural * o.natural;
    let (mut state, mut slider, mut sliding) = ((0.0, 0.0), 0.0, 0.0_f64);
    let mut result = SteadyPeriod { amplitude: 0.0, dissipated_energy: 0.0 };
    let step = period / 400.0;
    for cycle in 0..400 {
        result = SteadyPeriod { amplitude: 0.0, dissipated_energy: 0.0 };
        let start = (state, slider);
        let mut t = 0.0;
        while t < period {
            let full = step.min(period - t);
            // `sliding` is 0 in stick, else the sign of the force.
            let run = |h: f64| {
                if sliding == 0.0 {
                    motion(o, stick, o.lever * o.stiffness * slider, t, state, h)
                } else {
                    motion(o, slip, -o.lever * sliding * o.limit, t, state, h)
                }
            };
            let over = |end: (f64, f64)| {
                if sliding == 0.0 {
                    (o.stiffness * (o.lever * end.0 - slider)).abs() > o.limit
                } else {
                    sliding * o.lever * end.1 < 0.0
                }
            };
            let mut h = full;
            let event = over(run(full));
            if event {
                let mut low = 0.0;
                for _ in 0..60 {
                    let middle = 0.5 * (low + h);
                    if over(run(middle)) {
                        h = middle;
                    } else {
                        low = middle;
                    }
                }
            }
            let end = run(h);
            if sliding != 0.0 {
                result.dissipated_energy += o.limit * (o.lever * (end.0 - state.0)).abs();
                slider = o.lever * end.0 - sliding * o.limit / o.stiffness;
            }
            if event {
                sliding = if sliding == 0.0 { (o.lever * end.0 - slider).signum() } else { 0.0 };
            }
            state = end;
            result.amplitude = result.amplitude.max(end.0.abs());
            t += h.max(1e-15 * period);
        }
        let change =
            (state.0 - start.0.0).abs() + (o.lever * state.0 - slider - o.lever * start.0.0 + start.1).abs();
        if cycle > 20 && change < 1e-13 * result.amplitude {
            break;
        }
    }
    result
}
