"""A structure that is not ours: two masses in a row, made into an FMU by PythonFMU.

ground --k1,c1-- m1 --k2,c2-- m2 -- contact

The exciter acts on m1, the contact on m2. The force of the contact is restoring: it acts on m2 against the displacement.
"""

import math

from pythonfmu import DefaultExperiment, Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

MASSES = (1.0, 0.5)  # kg
STIFFNESSES = (4.0e5, 2.0e5)  # N/m
DAMPING = (4.0, 2.0)  # N.s/m
LONGEST_STEP = 2.5e-5  # s; the highest frequency is 150 Hz


class MassSpring(Fmi2Slave):
    description = "Two masses with springs and dampers"
    default_experiment = DefaultExperiment(start_time=0.0, stop_time=0.2, step_size=1e-4)

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.excitation = 0.0
        self.contact_force = 0.0
        self.displacement = 0.0
        self.velocity = 0.0
        self.displacement_1 = 0.0
        self.velocity_1 = 0.0
        for name in ("excitation", "contact_force"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        # A saved state is the values of all registered variables: these are all there is to remember.
        for name in ("displacement", "velocity", "displacement_1", "velocity_1"):
            variability = Fmi2Variability.continuous
            self.register_variable(Real(name, causality=Fmi2Causality.output, variability=variability))

    def derivatives(self, state):
        x1, v1, x2, v2 = state
        spring = STIFFNESSES[1] * (x2 - x1) + DAMPING[1] * (v2 - v1)
        a1 = (self.excitation + spring - STIFFNESSES[0] * x1 - DAMPING[0] * v1) / MASSES[0]
        a2 = (-spring - self.contact_force) / MASSES[1]
        return v1, a1, v2, a2

    def do_step(self, current_time, step_size):
        count = max(1, math.ceil(step_size / LONGEST_STEP - 1e-9))
        h = step_size / count
        state = (self.displacement_1, self.velocity_1, self.displacement, self.velocity)

        def moved(slope, factor):
            return tuple(value + factor * h * rate for value, rate in zip(state, slope))

        for _ in range(count):
            k1 = self.derivatives(state)
            k2 = self.derivatives(moved(k1, 0.5))
            k3 = self.derivatives(moved(k2, 0.5))
            k4 = self.derivatives(moved(k3, 1.0))
            slope = tuple((a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(k1, k2, k3, k4))
            state = moved(slope, 1.0)
        self.displacement_1, self.velocity_1, self.displacement, self.velocity = state
        return True
