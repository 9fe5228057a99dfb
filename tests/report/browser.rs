//! Reports in Chromium, as Debian packages it: `tests/interop/check_report.js`.

use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

use super::recordings::{reported, three_impacts, typed};

/// Every figure is visible, no text is clipped, the verdict is the first line and visible without scrolling, nothing is
/// requested, the console is empty; on two screens and on A4.
///
/// The environment variable `COLUMN_TWIN_KEEP_REPORTS` names a folder that keeps reports, screenshots and PDF files.
#[test]
#[ignore = "slow: Chromium, and its driver from npm"]
fn a_real_browser_shows_and_prints_every_report() {
    let folder = TempDir::new().unwrap();
    let kept = std::env::var_os("COLUMN_TWIN_KEEP_REPORTS");
    let folder = kept.as_deref().map_or(folder.path(), Path::new);
    std::fs::create_dir_all(folder).unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = |name: &str| root.join("config").join(name).display().to_string();
    let [paper, real] = ["heb220_paper.yaml", "heb220_s355.yaml"].map(config);
    let cases = [
        (
            "paper",
            format!("--config {paper} --mass 1500 --velocity 10"),
        ),
        ("real", format!("--config {real}")),
        (
            "elastic",
            format!("--config {real} --mass 100 --velocity 1"),
        ),
        (
            "collapse",
            format!("--config {real} --mass 20000 --velocity 20"),
        ),
        (
            "lorry",
            format!("--config {real} --vehicle lorry_8t --velocity 6"),
        ),
        (
            "oblique",
            format!("--config {real} --vehicle lorry_8t --velocity 6 --direction 45"),
        ),
        (
            "hostile",
            format!("--config {real} -p column_id:=<b>{}</b>", "x".repeat(200)),
        ),
    ];
    let mut reports = Vec::new();
    for (name, options) in cases {
        let path = folder.join(format!("{name}.html"));
        let line = format!("simulate {options} --report {}", path.display());
        let (code, _, stderr) = typed(folder, &line);
        assert_eq!(code, 0, "{line}: {stderr}");
        reports.push(path);
    }
    let recording = three_impacts();
    let path = folder.join("recording.html");
    let (code, _) = reported(&recording.path(), &path, &[]);
    assert_eq!(code, 0);
    reports.push(path);

    let environment = Command::new(root.join("tests/interop/node_environment.sh"))
        .output()
        .unwrap();
    assert!(
        environment.status.success(),
        "{}",
        String::from_utf8_lossy(&environment.stderr)
    );
    let modules = String::from_utf8(environment.stdout).unwrap();
    let checked = Command::new("node")
        .arg(root.join("tests/interop/check_report.js"))
        .arg(folder.join("shots"))
        .args(&reports)
        .env("NODE_PATH", modules.trim())
        .output()
        .unwrap();
    let stdout = String::from_utf8_lossy(&checked.stdout);
    let stderr = String::from_utf8_lossy(&checked.stderr);
    println!("{stdout}{stderr}");
    assert!(checked.status.success(), "{stdout}{stderr}");
    for name in ["paper", "recording"] {
        assert!(stdout.contains(&format!("{name}: ")), "{stdout}");
    }
}
