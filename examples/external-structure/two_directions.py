"""A structure that is not ours: a mass that moves in two directions, made into an FMU by PythonFMU.

xi along the contact, eta away from it; springs couple them. The forces of the contact are restoring: they act on the mass
against xi and eta. Steady forces act on it from the start: along the contact, and away from it.
"""

import math

from pythonfmu import DefaultExperiment, Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

MASS = 1.0  # kg
STIFFNESS = ((2.0e5, 3.0e4), (3.0e4, 4.0e5))  # N/m
DAMPING = 20.0  # N.s/m
LONGEST_STEP = 5e-5  # s; with the contact closed the highest frequency is 250 Hz


class TwoDirections(Fmi2Slave):
    description = "A mass on springs that moves along and away from a contact"
    default_experiment = DefaultExperiment(start_time=0.0, stop_time=0.02, step_size=1e-4)

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for name in ("excitation", "pull", "force", "opening_force"):
            setattr(self, name, 0.0)
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        # A saved state is the values of all registered variables: these are all there is to remember.
        for name in ("xi", "xi_rate", "eta", "eta_rate"):
            setattr(self, name, 0.0)
            variability = Fmi2Variability.continuous
            self.register_variable(Real(name, causality=Fmi2Causality.output, variability=variability))

    def derivatives(self, state):
        x, v, y, w = state
        along = self.excitation - self.force - DAMPING * v - STIFFNESS[0][0] * x - STIFFNESS[0][1] * y
        away = self.pull - self.opening_force - DAMPING * w - STIFFNESS[1][0] * x - STIFFNESS[1][1] * y
        return v, along / MASS, w, away / MASS

    def do_step(self, current_time, step_size):
        count = max(1, math.ceil(step_size / LONGEST_STEP - 1e-9))
        h = step_size / count
        state = (self.xi, self.xi_rate, self.eta, self.eta_rate)

        def moved(slope, factor):
            return tuple(value + factor * h * rate for value, rate in zip(state, slope))

        for _ in range(count):
            k1 = self.derivatives(state)
            k2 = self.derivatives(moved(k1, 0.5))
            k3 = self.derivatives(moved(k2, 0.5))
            k4 = self.derivatives(moved(k3, 1.0))
            slope = tuple((a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(k1, k2, k3, k4))
            state = moved(slope, 1.0)
        self.xi, self.xi_rate, self.eta, self.eta_rate = state
        return True
