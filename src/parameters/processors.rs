//! Lists of processors, as `taskset` and `cpuset` write them.

/// Highest number of a processor.
pub const MAX_PROCESSOR: usize = 1023;

/// The processors of a list such as `1,4-7`, in its order; `None` if the text is not such a list. An empty text is an empty
/// list.
#[must_use]
pub fn processors(list: &str) -> Option<Vec<usize>> {
    if list.trim().is_empty() {
        return Some(Vec::new());
    }
    let number = |text: &str| {
        let digits = text.trim();
        let all_digits = !digits.is_empty() && digits.bytes().all(|it| it.is_ascii_digit());
        let number = digits
            .parse::<usize>()
            .ok()
            .filter(|it| *it <= MAX_PROCESSOR);
        number.filter(|_| all_digits)
    };
    let mut found = Vec::new();
    let mut is_found = [false; MAX_PROCESSOR + 1];
    for part in list.split(',') {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        let (first, last) = (number(first)?, number(last)?);
        if first > last {
            return None;
        }
        found.extend((first..=last).filter(|&it| !std::mem::replace(&mut is_found[it], true)));
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_as_taskset_reads_them() {
        for (list, expected) in [
            ("", &[][..]),
            ("3", &[3]),
            (" 1, 4-6 ", &[1, 4, 5, 6]),
            ("2,0-2", &[2, 0, 1]),
            ("1023", &[1023]),
        ] {
            assert_eq!(processors(list).as_deref(), Some(expected), "{list}");
        }
        for wrong in ["-1", "1-", "2-1", "1,,2", "a", "1024", "+1", "1;2", ","] {
            assert_eq!(processors(wrong), None, "{wrong}");
        }
    }
}
