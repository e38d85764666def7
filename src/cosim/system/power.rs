//! Power exchanged between slaves, and the difference between the two sides.
//!
//! A contact takes a displacement from a structure and gives it a force. The two are stepped apart, so that the work
//! the structure does against the force it was given differs from the work the contact took for the motion it was
//! given. The difference is energy that the coupling itself adds or removes: the *residual energy* of the power
//! bond, δE = ∫ (P₁ − P₂) dt over the step, P₁ = F ũ̇ and P₂ = F̃ u̇, where a tilde marks what was *given* to a slave and its
//! absence what the slave *gave* (S. Sadjina, L. T. Kyllingstad, S. Skjong, E. Pedersen: Energy conservation and power bonds in
//! co-simulations: non-iterative adaptive step size control and error estimation, Engineering with Computers 33 (2017)
//! 607–620; F. González, S. Arbatani, A. Mohtat, J. Kövecses: Energy-leak monitoring and correction to enhance
//! stability in the co-simulation of mechanical systems, Mechanism and Machine Theory 131 (2019) 172–188).
//!
//! It is zero only if the coupling is exact. Positive: the side that gives the force took up more than the other lost,
//! which means that the coupling adds energy.
//!
//! Over a step of length H the integrals are taken as well as the values at its ends allow:
//! - the side that gives the force follows a straight line in the displacement it was given: `½ (F₀ + F₁) Δũ`;
//! - the side that takes a held force F̃ does the work `F̃ Δu`;
//! - the side that takes a force that runs linearly moves on a cubic through displacement and velocity at both ends:
//!   `½ (F̃₀ + F̃₁) Δu + (F̃₁ − F̃₀) (u̇₁ − u̇₀) H/12`.

use super::{Port, PowerConnection, System, SystemError};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    Force,
    Displacement,
    Velocity,
}

/// What a unit says about a variable.
fn role(unit: Option<&str>) -> Option<(Role, bool)> {
    let (role, rotational) = match unit? {
        "N" | "kN" | "mN" | "MN" => (Role::Force, false),
        "m" | "mm" | "um" | "µm" => (Role::Displacement, false),
        "m/s" | "mm/s" => (Role::Velocity, false),
        "N.m" | "N*m" | "Nm" | "kN.m" => (Role::Force, true),
        "rad" | "deg" => (Role::Displacement, true),
        "rad/s" | "deg/s" => (Role::Velocity, true),
        _ => return None,
    };
    Some((role, rotational))
}

impl System {
    /// Declares that the inputs `force` and `motion` (a displacement or a velocity), both (slave, variable), exchange
    /// power between their slaves. Pairs that the units identify are found without it.
    ///
    /// # Errors
    /// Unknown names, [`SystemError::Power`].
    pub fn declare_power(&mut self, force: (&str, &str), motion: (&str, &str)) -> Result<(), SystemError> {
        let (force, motion) = (self.port(force.0, force.1)?, self.port(motion.0, motion.1)?);
        match PowerConnection::declared(self, force, motion) {
            Ok(power) => self.power.push(power),
            Err(reason) => {
                let (force, motion) = (self.full_name(force), self.full_name(motion));
                return Err(SystemError::Power { force, motion, reason });
            }
        }
        Ok(())
    }

    /// The power connections: those declared, and those found by their units.
    pub fn power_connections(&self) -> Vec<PowerConnection> {
        PowerConnection::find(self)
    }
}

impl PowerConnection {
    /// By the inputs that take force and motion; the motion's role follows from its unit; without a unit it is a velocity.
    pub(in crate::cosim) fn declared(
        system: &System,
        force: Port,
        motion: Port,
    ) -> Result<Self, &'static str> {
        let source = |port: Port| system.connections.iter().find(|other| other.to == port);
        let (Some(f), Some(u)) = (source(force), source(motion)) else {
            return Err("an end is not connected");
        };
        if f.from.slave != motion.slave || u.from.slave != force.slave {
            return Err("they do not join the same two slaves");
        }
        let displacement =
            matches!(role(system.variable(motion).unit.as_deref()), Some((Role::Displacement, _)));
        Ok(Self {
            force,
            displacement: displacement.then_some(motion),
            velocity: (!displacement).then_some(motion),
        })
    }

    /// The declared ones, and each force between two slaves that has one motion in return.
    pub(in crate::cosim) fn find(system: &System) -> Vec<Self> {
        let mut found = system.power.clone();
        let ends = |port: Port| role(system.variable(port).unit.as_deref());
        for force in &system.connections {
            let Some((Role::Force, rotational)) = ends(force.to) else { continue };
            if found.iter().any(|power| power.force == force.to) {
                continue;
            }
            let (taker, giver) = (force.to.slave, force.from.slave);
            let back = |wanted: Role| {
                let returns = system.connections.iter().filter(move |other| {
                    (other.from.slave, other.to.slave) == (taker, giver)
                        && ends(other.to) == Some((wanted, rotational))
                });
                let list: Vec<Port> = returns.map(|other| other.to).collect();
                list
            };
            let rivals = system.connections.iter().filter(|other| {
                (other.from.slave, other.to.slave) == (giver, taker)
                    && ends(other.to) == Some((Role::Force, rotational))
            });
            let only = |list: Vec<Port>| if let [port] = list[..] { Some(port) } else { None };
            let (displacement, velocity) = (only(back(Role::Displacement)), only(back(Role::Velocity)));
            // Of several pairs between the same two only a declaration shows which belong together.
            if rivals.count() == 1 && taker != giver && (displacement.is_some() || velocity.is_some()) {
                found.push(Self { force: force.to, displacement, velocity });
            }
        }
        found
    }
}

/// What the two sides of a power connection accounted for, in the unit of work of the side that takes the force.
#[derive(Debug, Clone, PartialEq)]
pub struct EnergyResidual {
    /// `slave.variable` that takes the force.
    pub force: String,
    /// `slave.variable` that takes the motion.
    pub motion: String,
    /// Sum of the residuals (J): the energy that the coupling added, or removed if negative.
    pub sum: f64,
    /// Sum of their magnitudes (J).
    pub magnitude: f64,
    /// The largest of a step (J), in magnitude.
    pub largest: f64,
    /// Sum of the magnitudes of the work exchanged in each step (J), to compare with.
    pub exchanged: f64,
    /// The residual of the last step (J).
    pub last: f64,
}

/// Values at both ends of a step of what a connection carries: as given by one slave, and to the other.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::cosim) struct Ends {
    /// The source before and after the step.
    pub given: [f64; 2],
    /// The input at the beginning and the end, where it runs linearly; twice the same where it is held.
    pub taken: [f64; 2],
    /// How far the input came since the end of the last step, where it is a displacement.
    pub travel: f64,
    /// Factor of the connection.
    pub factor: f64,
}

/// Work of a step (J) as the side that takes the force and as the side that gives it account for it.
pub(in crate::cosim) fn works(
    force: Ends,
    displacement: Option<Ends>,
    velocity: Option<Ends>,
    step: f64,
) -> [f64; 2] {
    let mean = |pair: [f64; 2]| 0.5 * (pair[0] + pair[1]);
    let change = |pair: [f64; 2]| pair[1] - pair[0];
    let ramp = change(force.taken);
    let curve = |velocity: Ends| ramp * change(velocity.given) * step / 12.0;
    let (taker, travel, motion_factor) = match (displacement, velocity) {
        (Some(u), v) => {
            let taker = mean(force.taken) * change(u.given) + v.map_or(0.0, curve);
            (taker, u.travel, u.factor)
        }
        (None, Some(v)) => {
            let taker = mean(force.taken) * mean(v.given) * step + curve(v);
            (taker, mean(v.taken) * step, v.factor)
        }
        (None, None) => return [0.0; 2],
    };
    // In the taker's units, and with its sign.
    [taker, force.factor / motion_factor * mean(force.given) * travel]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_work_of_a_linear_force_along_a_cubic_is_exact() {
        // F = 3 − 2 t, u = 1 + t + 4 t² − 5 t³ over 0.7 s; ∫ F u̇ dt term by term.
        let h: f64 = 0.7;
        let (force, path) = (|t: f64| 3.0 - 2.0 * t, |t: f64| 1.0 + t + 4.0 * t * t - 5.0 * t.powi(3));
        let rate = |t: f64| 1.0 + 8.0 * t - 15.0 * t * t;
        let exact = 3.0 * h + 11.0 * h * h - 61.0 * h.powi(3) / 3.0 + 7.5 * h.powi(4);
        let ends = |value: &dyn Fn(f64) -> f64| Ends {
            given: [value(0.0), value(h)],
            taken: [value(0.0), value(h)],
            travel: value(h) - value(0.0),
            factor: 1.0,
        };
        let [taker, _] = works(ends(&force), Some(ends(&path)), Some(ends(&rate)), h);
        assert!((taker - exact).abs() < 1e-12, "{taker} {exact}");
        // A velocity that runs linearly, without the displacement.
        let velocity = |t: f64| 1.0 - 0.5 * t;
        let exact = 3.0 * h - 1.75 * h * h + h.powi(3) / 3.0;
        let [taker, _] = works(ends(&force), None, Some(ends(&velocity)), h);
        assert!((taker - exact).abs() < 1e-12, "{taker} {exact}");
        // The other side goes straight, in units of its own: mm and kN of the other sign.
        let kilo = Ends { given: [-0.003, -0.0016], factor: -1e3, ..ends(&force) };
        let milli = Ends { travel: 1e3 * h, factor: 1e3, ..ends(&path) };
        let [_, giver] = works(kilo, Some(milli), None, h);
        assert!((giver - 2.3 * h).abs() < 1e-12, "{giver}");
    }
}
