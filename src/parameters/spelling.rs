//! Suggestions for misspelt names.

/// Longest name for which similar ones are looked for \[characters\]: the search costs the product of both lengths.
const MAX_MISSPELT: usize = 64;

/// Whether a wrong name is short enough to look for the one that was meant.
pub(super) fn may_be_misspelt(name: &str) -> bool {
    name.chars().nth(MAX_MISSPELT).is_none()
}

/// The word that is nearest to a misspelt one; none where no word is similar.
pub(super) fn nearest_word<'a>(
    wrong: &str,
    words: impl DoubleEndedIterator<Item = &'a str>,
) -> Option<String> {
    if !may_be_misspelt(wrong) {
        return None;
    }
    let wrong = wrong.to_ascii_lowercase().replace('-', "_");
    let similar =
        |word: &&str| strsim::normalized_damerau_levenshtein(&wrong, &word.to_ascii_lowercase());
    // Of equally similar words the first one.
    let nearest = words
        .rev()
        .max_by(|a, b| similar(a).total_cmp(&similar(b)))?;
    (similar(&nearest) >= 0.5).then(|| nearest.to_owned())
}
