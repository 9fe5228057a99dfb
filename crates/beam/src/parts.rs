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
    /// Most by which it grows \[N\]; infinite for any amount.
    pub most: f64,
}

impl Slider {
    /// Force, tangent and plastic angle at a shear angle, from the plastic angle before.
    pub fn respond(&self, angle: f64, plastic: f64) -> (f64, f64, f64) {
        let force = self.rigidity * (angle - plastic);
        let outside = |back: f64| {
            let relative = force - back;
            relative - relative.max(-self.resistance).min(self.resistance)
        };
        let back = self.hardening * plastic;
        if outside(back.clamp(-self.most, self.most)) == 0.0 {
            return (force, self.rigidity, plastic);
        }
        let per = 1.0 / (self.rigidity + self.hardening);
        let flow = outside(back) * per;
        let grown = self.hardening * (plastic + flow);
        if back.abs() > self.most || grown.abs() > self.most {
            // The hardening ends, on the side on which it began or on the other one.
            for side in [1.0, -1.0] {
                let flow = outside(side * self.most) / self.rigidity;
                if side * self.hardening * (plastic + flow) >= self.most {
                    return (force - self.rigidity * flow, 0.0, plastic + flow);
                }
            }
        }
        let tangent = self.rigidity * self.hardening * per;
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A single step from one end of the hardening beyond the other one went on hardening.
    #[test]
    fn a_slider_hardens_no_further_than_its_most() {
        let slider = Slider {
            rigidity: 1e9,
            resistance: 1e6,
            hardening: 2e7,
            most: 4e5,
        };
        let mut plastic = 0.0;
        let mut angle = 0.0_f64;
        // Out, back beyond the other side, and out again.
        for (end, steps) in [(0.05, 50_000), (-0.08, 130_000), (0.03, 110_000)] {
            let begin = angle;
            let at_once = slider.respond(end, plastic);
            for step in 1..=steps {
                angle = begin + (end - begin) * f64::from(step) / f64::from(steps);
                let (force, tangent, after) = slider.respond(angle, plastic);
                assert!(force.abs() <= 1.4e6 * (1.0 + 1e-9), "{angle}: {force}");
                assert!((0.0..=1e9).contains(&tangent), "{angle}: {tangent}");
                plastic = after;
            }
            // The hardening is over.
            assert!((at_once.0.abs() - 1.4e6).abs() < 1.0, "{at_once:?}");
            assert_eq!(at_once.1, 0.0);
            assert!((at_once.2 - plastic).abs() < 1e-9, "{at_once:?} {plastic}");
            assert_eq!(at_once.0.signum(), (end - begin).signum());
        }
        // Half way there, by hand: a force of 1.2 MN after a plastic angle of 0.01.
        let (force, tangent, plastic) = slider.respond(0.0112, 0.0);
        assert!((force - 1.2e6).abs() < 1.0 && (plastic - 0.01).abs() < 1e-9);
        assert!((tangent - 2e7 / 1.02).abs() < 1.0, "{tangent}");
        // Without a limit it goes on.
        let endless = Slider {
            most: f64::INFINITY,
            ..slider
        };
        assert!(endless.respond(0.05, 0.0).0 > 1.4e6);
    }
}
