//! What the comparisons have found, as tables in `data/found/`, from which the program's page of validation is made.

use std::path::Path;

/// Compares the rows of a comparison with those that are kept; `UPDATE_DOCS=1` keeps new ones.
pub fn keep(name: &str, header: &str, rows: &[String]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/found");
    let path = folder.join(format!("{name}.csv"));
    let text = format!("{header}\n{}\n", rows.join("\n"));
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(&path, &text).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        kept == text,
        "{} differs from what is computed; keep it with\n    \
         UPDATE_DOCS=1 cargo test --release -p column_beam\nand then make docs/validation.md again\n\n{text}",
        path.display()
    );
}
