//! What a beam is made of: elements, their shear, and the springs of its supports.

/// Shear that the web between flange and its middle plane, and the frame of the flanges, bear: elastic and plastic, without
/// normal stress.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Slider {
    /// Force per shear angle \[N\].
    pub rigidity: f64,
    pub resistance: f64,
    /// Growth of the resistance with the plastic angle \[N\].
    pub hardening: f64,
}

impl Slider {
    /// Force, tangent and plastic angle at a shear angle, from the plastic angle before.
    pub fn respond(&self, angle: f64, plastic: f64) -> (f64, f64, f64) {
        let force = self.rigidity * (angle - plastic);
        let relative = force - self.hardening * plastic;
        let beyond = relative - relative.max(-self.resistance).min(self.resistance);
        if beyond == 0.0 {
            return (force, self.rigidity, plastic);
        }
        let per = 1.0 / (self.rigidity + self.hardening);
        let tangent = self.rigidity * self.hardening * per;
        let flow = beyond * per;
        (force - self.rigidity * flow, tangent, plastic + flow)
    }
}

/// An element between a node and the next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Element<const R: usize> {
    pub length: f64,
    /// Deformations of the unloaded element, which may be bowed.
    pub initial: [f64; R],
    pub sliders: [Slider; 2],
    /// Which part of the column shears with it; none behind the bumper or without shear.
    pub bar: Option<usize>,
}

/// A spring against the rotation of a node, about z and y \[N m/rad\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct RotationSpring {
    pub node: usize,
    pub stiffness: f64,
}
