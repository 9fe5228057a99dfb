//! What the model cannot know, in plain words.

/// How well the two bars agree with a fibre beam model that was written independently. The test that writes
/// `docs/validation.md` computes these figures and fails where they differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FibreAgreement {
    /// Number of hits by rigid masses.
    pub cases: usize,
    /// Root mean square deviation of the peak displacement \[%\].
    pub peak: f64,
    /// The same of the residual displacement \[%\].
    pub residual: f64,
    /// Ratio of the peak displacement in the case in which it is lowest.
    pub lowest: f64,
    /// Mean contact force over the first millisecond, over that of the fibre beam, from and to.
    pub first_force: [f64; 2],
    /// How much too high the speed is at which the column collapses \[%\].
    pub collapse_speed: f64,
}

/// The figures.
pub(crate) const FIBRE_AGREEMENT: FibreAgreement = FibreAgreement {
    cases: 9,
    peak: 1.5,
    residual: 1.9,
    lowest: 0.968,
    first_force: [0.77, 1.16],
    collapse_speed: 4.0,
};

/// Limits of the model, each with its consequence for the reader.
pub(super) fn limits() -> [(&'static str, String); 9] {
    let it = FIBRE_AGREEMENT;
    let [low, high] = it.first_force;
    [
        (
            "The model is plane.",
            "The column bends about one axis. Of a hit from another direction the component in the plane counts; torsion and buckling \
             about the other axis during the impact are not followed. The fibre beam of the second opinion follows them."
                .to_owned(),
        ),
        (
            "Two rigid bars with hinges stand for the column.",
            format!(
                "Plastic deformation happens at the base, at the impact point and at the top only. Over {} plastic hits by \
                 rigid masses, the peak displacement agrees with a fibre beam model to {:.1} % (root mean square) and the \
                 residual to {:.1} %; the worst case is {:.1} % too low, at a load of 1.2 MN on a soft top.",
                it.cases,
                it.peak,
                it.residual,
                100.0 * (1.0 - it.lowest)
            ),
        ),
        (
            "The speed of collapse is uncertain.",
            format!(
                "It is about {:.0} % too high, which is on the unsafe side: treat an impact within 5 % of the critical speed as \
                 a collapse.",
                it.collapse_speed
            ),
        ),
        (
            "The first millisecond is not reliable.",
            format!(
                "Flexural waves are not part of the model: the contact force averaged over the first millisecond is {low} to \
                 {high} times the force in the fibre beam."
            ),
        ),
        (
            "The peak force of a rigid vehicle has no physical meaning.",
            "It depends on the stiffness of the hinges alone; only its mean over a millisecond can be used. A real vehicle \
             has a front that crushes."
                .to_owned(),
        ),
        (
            "The base moment is not reliable under a high load.",
            "The model neglects the axial inertia along the bars.".to_owned(),
        ),
        (
            "Near the onset of yielding, results are sensitive.",
            "One per cent of strength changes the displacement by several per cent: read the range, not the number.".to_owned(),
        ),
        (
            "Local failure is not part of the model.",
            "Dents, welds, splices and the concrete around the anchors may fail before the section does. Crippling of the web, \
             the dent of the flange under the bumper, and the torsion of a column that is hit off its axis are not evaluated."
                .to_owned(),
        ),
        (
            "The surroundings are a spring, a mass and a load at the top.",
            "Neighbouring members, fire and further impacts are not considered.".to_owned(),
        ),
    ]
}
