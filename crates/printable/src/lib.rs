//! Text from outside as it may appear in logs, errors, tables and on a terminal, and bytes as digits.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - hexadecimal.rs: Bytes as hexadecimal digits

mod hexadecimal;

use std::{fmt, io};

pub use hexadecimal::Hexadecimal;

/// A text whose control characters and invisible formatting characters are escaped (`\n`, `\u{1b}`, `\u{202e}`): a terminal would
/// obey the former, and the latter can make a name look like another one or show a line in another order.
#[derive(Debug, Clone, Copy)]
pub struct Printable<'a>(pub &'a str);

impl fmt::Display for Printable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.chars().try_for_each(|c| match is_printable(c) {
            true => write!(f, "{c}"),
            false => write!(f, "{}", c.escape_default()),
        })
    }
}

/// Whether a character is neither a control character nor an invisible formatting character (Unicode: bidirectional controls,
/// zero-width characters, separators of lines and paragraphs, tags).
#[must_use]
pub fn is_printable(c: char) -> bool {
    !c.is_control()
        && !matches!(
            c,
            '\u{ad}'
                | '\u{61c}'
                | '\u{180e}'
                | '\u{200b}'..='\u{200f}'
                | '\u{2028}'..='\u{202e}'
                | '\u{2060}'..='\u{206f}'
                | '\u{feff}'
                | '\u{fff9}'..='\u{fffb}'
                | '\u{e0000}'..='\u{e007f}'
        )
}

/// Text of several lines for people, such as an error: as [`Printable`], but line breaks and tabs are kept.
#[derive(Debug, Clone, Copy)]
pub struct PrintableLines<'a>(pub &'a str);

impl fmt::Display for PrintableLines<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.split_inclusive(['\n', '\t']).try_for_each(|part| {
            let line = part.strip_suffix(['\n', '\t']).unwrap_or(part);
            write!(f, "{}{}", Printable(line), &part[line.len()..])
        })
    }
}

/// Writes text for people as [`PrintableLines`] shows it: for the output of commands, whose tables hold names from outside.
#[derive(Debug)]
pub struct PrintableWriter<W>(pub W);

impl<W: io::Write> io::Write for PrintableWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let valid = match std::str::from_utf8(bytes) {
            Ok(text) => text,
            Err(error) => std::str::from_utf8(&bytes[..error.valid_up_to()]).unwrap_or_default(),
        };
        if valid.is_empty() {
            // A character that was cut in two, or no text.
            return self.0.write(bytes);
        }
        write!(self.0, "{}", PrintableLines(valid))?;
        Ok(valid.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_a_command_are_kept_and_escaped() {
        use io::Write;
        let mut writer = PrintableWriter(Vec::new());
        let name = "c\u{202e}d\r";
        writeln!(writer, "  a\u{1b}[2J\tb\n  {name}").expect("written");
        let shown = String::from_utf8(writer.0).expect("text");
        assert_eq!(shown, "  a\\u{1b}[2J\tb\n  c\\u{202e}d\\r\n");
    }

    #[test]
    fn what_a_terminal_obeys_or_hides_is_escaped() {
        for (text, shown) in [
            ("Stütze A3 – 柱 №1", "Stütze A3 – 柱 №1"),
            ("a\nb\tc\u{7f}", r"a\nb\tc\u{7f}"),
            ("\u{1b}[31mred", r"\u{1b}[31mred"),
            ("\u{9b}2J", r"\u{9b}2J"),
            // Shown as column_3A by a terminal that knows bidirectional text.
            ("column_\u{202e}A3", r"column_\u{202e}A3"),
            (
                "a\u{200b}b\u{feff}\u{2066}\u{e0041}",
                r"a\u{200b}b\u{feff}\u{2066}\u{e0041}",
            ),
            ("line\u{2028}separator", r"line\u{2028}separator"),
        ] {
            assert_eq!(Printable(text).to_string(), shown);
        }
    }
}
