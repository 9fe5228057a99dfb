//! What the model cannot know, in plain words.

/// Limits of the model, each with its consequence for the reader. Figures come from a comparison with a fibre beam model
/// of other authorship and from the analytic solutions in `docs/validation.md`.
pub(super) const LIMITS: [(&str, &str); 9] = [
    (
        "The model is plane.",
        "The column bends about one axis, in the vehicle's direction. Torsion, an oblique hit and buckling about the other \
         axis during the impact are not followed.",
    ),
    (
        "Two rigid bars with hinges stand for the column.",
        "Plastic deformation happens at the base, at the impact point and at the top only. Over 14 plastic hits by rigid \
         masses, the largest displacement agrees with a fibre beam model to 2.0 % (root mean square) and the residual to \
         2.3 %; the worst case is 4.8 % too low, at a load of 1.2 MN on a soft top. With an elliptical yield surface and \
         uncoupled hinges, as in the paper's example, displacements are 4 to 5 % too low.",
    ),
    (
        "The speed at which the column collapses is about 4 % too high.",
        "This is on the unsafe side: treat an impact within 5 % of the critical speed as a collapse.",
    ),
    (
        "The first millisecond is not reliable.",
        "Flexural waves are not part of the model: the contact force averaged over the first millisecond is 0.77 to 1.16 \
         times that of the fibre beam.",
    ),
    (
        "The peak force of a rigid vehicle has no physical meaning.",
        "It depends on the stiffness of the hinges alone; only its mean over a millisecond can be used. A real vehicle has a \
         front that crushes: choose one from the catalogue.",
    ),
    (
        "The base moment is not reliable under a high load.",
        "The model neglects the axial inertia along the bars.",
    ),
    (
        "Near the onset of yielding, results are sensitive.",
        "One per cent of strength changes the displacement by several per cent: read the band, not the number.",
    ),
    (
        "Local failure is not part of the model.",
        "Dents, tearing, bolts, base plates and welds may fail before the section does. Crippling of the web and the dent of \
         the flange under the bumper, and the torsion of a column that is hit beside its axis, are not evaluated.",
    ),
    (
        "The surroundings are a spring, a mass and a load at the top.",
        "Neighbouring members, fire and further impacts are not considered.",
    ),
];
