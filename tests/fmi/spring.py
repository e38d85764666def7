"""A mass on a spring, with a load of three parts, by semi-implicit steps."""

import numpy as np
from pythonfmu3 import Boolean, Dimension, Float64, Fmi3Causality, Fmi3Slave, Fmi3Variability, Int32


class Spring(Fmi3Slave):
    author = "test"
    description = "A mass on a spring"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.time = 0.0
        self.stiffness, self.load = 4.0, 1.0
        self.position, self.speed, self.count, self.moving = 0.0, 0.0, 0, False
        self.shares = np.array([0.75, -0.5, 0.25])
        self.forces = np.zeros(3)
        free, output = Fmi3Variability.tunable, Fmi3Causality.output
        self.register_variable(
            Float64("time", causality=Fmi3Causality.independent, variability=Fmi3Variability.continuous)
        )
        self.register_variable(Float64("stiffness", causality=Fmi3Causality.parameter, variability=free))
        self.register_variable(Float64("load", causality=Fmi3Causality.input))
        self.register_variable(Float64("position", causality=output))
        self.register_variable(Int32("count", causality=output))
        self.register_variable(Boolean("moving", causality=output))
        self.register_variable(Float64("forces", causality=output, dimensions=[Dimension(start="3")]))

    def do_step(self, current_time, step_size):
        self.forces = self.load * self.shares
        self.speed += step_size * (float(np.sum(self.forces)) - self.stiffness * self.position)
        self.position += step_size * self.speed
        self.count += 1
        self.moving = abs(self.speed) > 0.2
        return True
