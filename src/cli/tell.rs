//! Lines on standard error, which may be closed: the exit code stays what it is.

/// As `eprintln!`, without a panic where nobody reads.
macro_rules! tell {
    ($($text:tt)*) => {{
        // The reader of the error is gone, and so is the place to report that.
        let _ = std::io::Write::write_fmt(
            &mut std::io::stderr(),
            format_args!("{}\n", format_args!($($text)*)),
        );
    }};
}
