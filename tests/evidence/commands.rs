//! The commands `simulate --record`, `verify` and `replay`, run as by a user.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use tempfile::TempDir;

pub fn typed(folder: &Path, line: &str) -> (i32, String, String) {
    let Output {
        status,
        stdout,
        stderr,
    } = Command::cargo_bin("column-twin")
        .unwrap()
        .current_dir(folder)
        .args(line.split(' '))
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (status.code().unwrap(), text(stdout), text(stderr))
}

/// Version 0.1 computed other bits without FMA and AVX2: `verify` found 107 differences in a genuine recording.
#[test]
fn a_recording_made_on_one_processor_is_verified_on_another() {
    const WITHOUT_FMA: (&str, &str) = (
        "GLIBC_TUNABLES",
        "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-FMA_Usable,-AVX2_Usable",
    );
    /// Columns with powers and angles in every part of the model: uncommon exponents, damping, a vehicle of several masses,
    /// strain rate, hardening.
    const COLUMNS: [&str; 2] = [
        "--velocity 8 -p yield_surface.alpha:=1.7 -p yield_surface.beta:=1.3 -p damping.ratio:=0.02",
        "--velocity 7 --vehicle lorry_8t -p yield_surface.beta:=2.6 -p rate.law:=cowper_symonds -p hardening.ratio:=0.01",
    ];
    let folder = TempDir::new().unwrap();
    let run = |line: &str, without_fma: bool| {
        let mut command = Command::cargo_bin("column-twin").unwrap();
        command
            .current_dir(folder.path())
            .args(line.split(' '))
            .envs(without_fma.then_some(WITHOUT_FMA));
        command.output().unwrap()
    };
    for (index, column) in COLUMNS.into_iter().enumerate() {
        for recorded_without_fma in [false, true] {
            let bag = format!("bag_{index}_{recorded_without_fma}");
            let simulate = format!("simulate {column} --record {bag}");
            let recorded = run(&simulate, recorded_without_fma);
            assert!(recorded.status.success(), "{recorded:?}");
            let verified = run(&format!("verify {bag}"), !recorded_without_fma);
            let text = String::from_utf8_lossy(&verified.stdout);
            assert!(
                verified.status.success() && text.contains("Equal: "),
                "{column}: {text}"
            );
            // Hashes and signatures are the same, too, whichever instructions compute them.
            assert!(text.contains("it holds: all "), "{column}: {text}");
        }
    }
}

#[test]
fn a_simulated_impact_is_recorded_and_verified() {
    let folder = TempDir::new().unwrap();
    for (index, options) in [
        "--mass 1500 --velocity 10",
        "--velocity 3 --gap 0.123 --height 1.3 --record-stamp 1700000000.5",
        "--velocity 8 -p record.compression:=zstd -p publish_rate:=5000.0",
    ]
    .into_iter()
    .enumerate()
    {
        let (code, stdout, stderr) = typed(
            folder.path(),
            &format!("simulate {options} --record bag_{index}"),
        );
        assert_eq!(code, 0, "{stderr}");
        assert!(
            stdout.contains(&format!("Recording  bag_{index}")),
            "{stdout}"
        );
        for bag in [
            format!("bag_{index}"),
            format!("bag_{index}/bag_{index}_0.mcap"),
        ] {
            let (code, stdout, stderr) = typed(folder.path(), &format!("verify {bag}"));
            assert_eq!(code, 0, "{stdout}{stderr}");
            assert!(
                stdout.contains("which is this build") && stdout.contains("Equal: "),
                "{stdout}"
            );
        }
    }
    // Nothing is overwritten.
    let (code, _, stderr) = typed(folder.path(), "simulate --record bag_0");
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("exists already"), "{stderr}");
}

/// For example with `| head`.
#[test]
fn a_closed_standard_output_is_no_failure() {
    use std::process::Stdio;

    let folder = TempDir::new().unwrap();
    let (code, ..) = typed(folder.path(), "simulate --record bag");
    assert_eq!(code, 0);
    let mut lines = vec![
        "verify bag",
        "info bag",
        "info bag --json",
        "export bag --json --output -",
        "idl",
    ];
    if cfg!(feature = "viewer") {
        lines.push("replay bag --rrd impact.rrd");
    }
    for line in lines {
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_column-twin"))
            .current_dir(folder.path())
            .args(line.split(' '))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), &*stderr), (Some(0), ""), "{line}");
    }
}

#[test]
fn one_flipped_bit_ends_with_code_1_and_is_named() {
    let folder = TempDir::new().unwrap();
    let (code, ..) = typed(folder.path(), "simulate --record bag");
    assert_eq!(code, 0);
    let path = folder.path().join("bag/bag_0.mcap");
    let bytes = std::fs::read(&path).unwrap();
    let (_kept, forged) = super::forgeries::with_one_bit_flipped(&folder.path().join("bag"));
    let (code, stdout, stderr) = typed(folder.path(), &format!("verify {}", forged.display()));
    assert_eq!(code, 1, "{stdout}{stderr}");
    assert!(stdout.contains("/column_state: v1 is "), "{stdout}");
    assert!(
        stderr.contains("differs from the recomputation"),
        "{stderr}"
    );
    assert_eq!(std::fs::read(&path).unwrap(), bytes);
}

#[test]
fn input_that_is_not_a_recording_ends_with_code_2() {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("text.mcap"), "no recording").unwrap();
    std::fs::write(folder.path().join("empty.mcap"), "").unwrap();
    std::fs::create_dir(folder.path().join("folder")).unwrap();
    for bag in ["nothing", "text.mcap", "empty.mcap", "folder"] {
        for command in ["verify", "replay"] {
            let (code, stdout, stderr) = typed(folder.path(), &format!("{command} {bag}"));
            assert_eq!(code, 2, "{command} {bag}: {stdout}{stderr}");
            assert!(stderr.contains(bag), "{command} {bag}: {stderr}");
        }
    }
    for line in [
        "replay bag --rate 0",
        "replay bag --rate fast",
        "replay bag --clock -1",
    ] {
        let (code, _, stderr) = typed(folder.path(), line);
        assert_eq!(code, 2, "{line}");
        assert!(
            stderr.contains("expected a number from"),
            "{line}: {stderr}"
        );
    }
}

/// The viewer needs nothing but the recording.
#[cfg(feature = "viewer")]
#[test]
fn a_recording_becomes_a_file_for_the_viewer_or_is_served() {
    use std::io::{BufRead, BufReader};
    use std::net::{Ipv4Addr, TcpListener, TcpStream};
    use std::process::Stdio;

    let folder = TempDir::new().unwrap();
    let (code, ..) = typed(folder.path(), "simulate --height 1.3 --record bag");
    assert_eq!(code, 0);
    let (code, stdout, stderr) = typed(folder.path(), "replay bag --rrd impact.rrd");
    assert_eq!((code, stderr.as_str()), (0, ""), "{stdout}");
    assert_eq!(stdout, "rerun impact.rrd\n");
    let film = std::fs::read(folder.path().join("impact.rrd")).unwrap();
    assert_eq!(&film[..4], b"RRF2");
    for line in [
        "replay bag --rrd impact.rrd --topics /column_state",
        "replay bag --rrd impact.rrd --loop",
        "replay bag --serve --clock",
        "replay bag --serve --rate 2",
        "replay bag --rrd other.rrd --rate 0.5",
        "replay bag --rrd other.rrd --serve",
        "replay bag --config port.yaml",
        "replay nothing --rrd impact.rrd",
        "replay bag --rrd impact.rrd --config nothing.yaml",
    ] {
        let (code, _, stderr) = typed(folder.path(), line);
        assert_eq!(code, 2, "{line}: {stderr}");
    }
    let (code, _, stderr) = typed(folder.path(), "replay bag --rrd nowhere/impact.rrd");
    assert_eq!(code, 1, "{stderr}");
    assert!(
        stderr.contains("cannot write nowhere/impact.rrd"),
        "{stderr}"
    );

    let free = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let port = free.local_addr().unwrap().port();
    drop(free);
    let config = folder.path().join("port.yaml");
    let text = format!("/**:\n  ros__parameters:\n    viewer:\n      port: {port}\n");
    std::fs::write(&config, text).unwrap();
    let mut serving = std::process::Command::new(env!("CARGO_BIN_EXE_column-twin"))
        .current_dir(folder.path())
        .args(["replay", "bag", "--serve", "--config"])
        .arg(&config)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    let mut lines = BufReader::new(serving.stdout.take().unwrap());
    lines.read_line(&mut line).unwrap();
    assert!(
        line.contains(&format!("rerun rerun+http://127.0.0.1:{port}/proxy")),
        "{line}"
    );
    TcpStream::connect((Ipv4Addr::LOCALHOST, port)).unwrap();
    let (code, _, stderr) = typed(
        folder.path(),
        &format!("replay bag --serve --config {}", config.display()),
    );
    assert_eq!(code, 1, "{stderr}");
    assert!(stderr.contains("another program listens"), "{stderr}");
    let pid = rustix::process::Pid::from_raw(i32::try_from(serving.id()).unwrap()).unwrap();
    rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
    assert!(serving.wait().unwrap().success());
}
