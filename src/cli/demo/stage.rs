//! What the demonstrations share: a folder, processes of this program in a domain of their own, and the verified recording.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use crate::cli::failure::{Exit, Failure, LinePrinter};
use crate::cli::run::environment;
use column_twin::evidence::{self, Verification};
use column_twin::ros::{Environment, FreshDomain, RosArguments, StopSignals};

/// Maximum number of folders of demonstrations.
const MAX_FOLDERS: u32 = 1000;

/// Maximum time that another process may take to exit.
const EXIT_TIMEOUT: Duration = Duration::from_secs(20);

/// Interval at which the exit of another process is looked for.
const CHILD_INTERVAL: Duration = Duration::from_millis(10);

/// Last lines of a log that are shown with a failure.
const SHOWN_LINES: usize = 8;

/// Where a demonstration takes place.
pub(super) struct Stage<'a, 'b> {
    /// The folder for all files.
    pub folder: &'a Path,
    /// Loopback, in a domain that nobody else uses.
    pub environment: Environment,
    /// Whether the demonstration is asked to stop.
    pub signals: &'a StopSignals,
    /// For people.
    pub out: &'a LinePrinter<'b>,
    /// When it began.
    pub started: Instant,
    /// Reserves the domain.
    _domain: FreshDomain,
}

impl<'a, 'b> Stage<'a, 'b> {
    /// Takes a domain and says where everything is.
    pub fn set(
        folder: &'a Path,
        signals: &'a StopSignals,
        out: &'a LinePrinter<'b>,
    ) -> Result<Self, Failure> {
        let started = Instant::now();
        let domain = FreshDomain::take().ok_or_else(|| {
            Failure::plain(
                Exit::Failed,
                "every DDS domain from 1 to 101 is in use on 127.0.0.1; stop other demonstrations and tests first",
            )
        })?;
        // Node and client belong to the same enclave, if the environment names one.
        let environment = Environment {
            security: environment(&RosArguments::default())?.security,
            ..domain.environment.clone()
        };
        out.print(format_args!(
            "Everything stays on this machine: 127.0.0.1, DDS domain {}. Files: {}\n",
            environment.domain_id,
            folder.display()
        ));
        Ok(Self {
            folder,
            environment,
            signals,
            out,
            started,
            _domain: domain,
        })
    }

    /// Writes a file into the folder.
    pub fn write(&self, name: &str, content: &str) -> Result<(), Failure> {
        let path = self.folder.join(name);
        fs::write(&path, content).map_err(|error| cannot("write", &path, &error))
    }

    /// Fails once the program is asked to stop.
    pub fn unless_asked(&self) -> Result<(), Failure> {
        match self.signals.asked() {
            true => Err(Failure::plain(Exit::Failed, "interrupted")),
            false => Ok(()),
        }
    }

    /// Starts the node with these parameter files of the folder and these parameters.
    pub fn start_node(
        &self,
        configs: &[&str],
        parameters: &[&str],
    ) -> Result<ChildProcess, Failure> {
        let inside = |name: &str| self.folder.join(name).display().to_string();
        let mut settings = vec![
            format!("state.directory:={}", inside("state")),
            "record.mode:=always".to_owned(),
            format!("record.directory:={}", inside("recordings")),
        ];
        if cfg!(feature = "viewer") {
            settings.push("viewer.mode:=save".to_owned());
            settings.push(format!("viewer.directory:={}", inside("viewer")));
        }
        settings.extend(parameters.iter().map(|it| (*it).to_owned()));
        let mut arguments = vec!["run".to_owned()];
        for config in configs {
            arguments.extend(["--config".to_owned(), inside(config)]);
        }
        arguments.push("--ros-args".to_owned());
        arguments.extend(settings.into_iter().flat_map(|it| ["-p".to_owned(), it]));
        let node = self.start("node", &arguments)?;
        let named: String = configs.iter().map(|it| format!(" --config {it}")).collect();
        self.out.print(format_args!(
            "Node started: column-twin run{named} --ros-args -p record.mode:=always ..."
        ));
        Ok(node)
    }

    /// Starts this program in the domain of the demonstration, with its output in `NAME.log`.
    pub fn start(&self, name: &str, arguments: &[String]) -> Result<ChildProcess, Failure> {
        let log = self.folder.join(format!("{name}.log"));
        let own = std::env::current_exe().map_err(|error| Failure::plain(Exit::Failed, error))?;
        let open = || File::options().create(true).append(true).open(&log);
        let (out, err) = open()
            .and_then(|out| Ok((out, open()?)))
            .map_err(|error| cannot("write", &log, &error))?;
        let child = Command::new(own)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(out)
            .stderr(err)
            .env("ROS_DOMAIN_ID", self.environment.domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .env_remove("ROS_LOCALHOST_ONLY")
            .env_remove("ROS_STATIC_PEERS")
            .env_remove("ROS_NAMESPACE")
            .spawn()
            .map_err(|error| {
                Failure::plain(Exit::Failed, format!("cannot start {name}: {error}"))
            })?;
        Ok(ChildProcess { child, log })
    }

    /// Runs this program to its end; `what` could not be done if it fails.
    pub fn run(&self, name: &str, arguments: &[String], what: &str) -> Result<(), Failure> {
        let mut process = self.start(name, arguments)?;
        let status = loop {
            if let Some(status) = process.ended()? {
                break status;
            }
            self.unless_asked()?;
            std::thread::sleep(CHILD_INTERVAL);
        };
        match status.success() {
            true => Ok(()),
            false => {
                let failed = format!("{what} cannot be made");
                Err(process.explain(Failure::plain(Exit::Failed, failed)))
            }
        }
    }

    /// Stops the node, which has to exit cleanly.
    pub fn stop_node(&self, node: &mut ChildProcess) -> Result<(), Failure> {
        match node.stop() {
            Some(status) if status.success() => Ok(()),
            _ => Err(node.explain(Failure::plain(
                Exit::Failed,
                "the node did not exit cleanly",
            ))),
        }
    }

    /// Verifies the only recording of the node by recomputation, and returns where it is.
    pub fn verify(&self) -> Result<(PathBuf, Verification), Failure> {
        let recording = only_entry(&self.folder.join("recordings"))?;
        let found =
            evidence::verify(&recording).map_err(|error| Failure::plain(Exit::Failed, error))?;
        if !found.is_equal() {
            return Err(Failure::plain(
                Exit::Failed,
                format!("the recording differs from the recomputation:\n{found}"),
            ));
        }
        self.out.print(format_args!(
            "Recording verified by recomputation: {} messages are equal bit for bit.",
            found.compared()
        ));
        Ok((recording, found))
    }

    /// Says what can be found in the folder besides its `files`, and what to try next.
    pub fn print_end(&self, recording: &Path, files: &[[&str; 2]], next: &[String]) {
        let (out, folder) = (self.out, self.folder.display());
        let took = self.started.elapsed().as_secs_f64();
        out.print(format_args!("\nFinished in {took:.1} s. Files:"));
        for [name, what] in files {
            out.print(format_args!("  {folder}/{name:<13} {what}"));
        }
        out.print(format_args!(
            "  {}    everything that the node received and sent (MCAP, for ros2 bag, Foxglove, PlotJuggler)",
            recording.display()
        ));
        if cfg!(feature = "viewer") {
            out.print(format_args!(
                "  {folder}/viewer      the deforming column, for the Rerun viewer"
            ));
        }
        out.print(format_args!(
            "  {folder}/state       the damage, from which the next start continues\n"
        ));
        out.print("Try next:");
        for command in next {
            out.print(format_args!("  {command}"));
        }
        match cfg!(feature = "viewer") {
            true => out.print(format_args!(
                "  rerun {folder}/viewer/*.rrd        (pip install rerun-sdk==0.36.3)"
            )),
            false => out.print("  column-twin simulate --help"),
        }
    }
}

/// A process of this program, which stops when the value is dropped.
pub(super) struct ChildProcess {
    child: Child,
    log: PathBuf,
}

impl ChildProcess {
    /// How it has ended, if it has.
    pub fn ended(&mut self) -> Result<Option<ExitStatus>, Failure> {
        let status = self.child.try_wait();
        status.map_err(|error| Failure::plain(Exit::Failed, error))
    }

    /// Stops it as Ctrl-C does; `None` if it had to be killed.
    pub fn stop(&mut self) -> Option<ExitStatus> {
        if let Some(id) = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw) {
            let _ = kill_process(id, Signal::INT); // it may have exited already
        }
        let deadline = Instant::now() + EXIT_TIMEOUT;
        while Instant::now() < deadline {
            match self.child.try_wait() {
                Ok(Some(status)) => return Some(status),
                Ok(None) => std::thread::sleep(CHILD_INTERVAL),
                Err(_) => break,
            }
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
        None
    }

    /// Adds the last lines of its log.
    pub fn explain(&self, failure: Failure) -> Failure {
        let log = fs::read_to_string(&self.log).unwrap_or_default();
        let lines: Vec<_> = log.lines().collect();
        let last = lines[lines.len().saturating_sub(SHOWN_LINES)..].join("\n  ");
        Failure::plain(
            failure.exit,
            format!(
                "{}\nThe last lines of {}:\n  {last}",
                failure.report,
                self.log.display()
            ),
        )
    }
}

impl Drop for ChildProcess {
    fn drop(&mut self) {
        if matches!(self.child.try_wait(), Ok(None)) {
            self.stop();
        }
    }
}

fn cannot(what: &str, path: &Path, error: &io::Error) -> Failure {
    let path = path.display();
    Failure::plain(
        Exit::Failed,
        format!("cannot {what} {path}: {error}; name a writable folder with --output"),
    )
}

/// Creates a new folder.
pub(super) fn new_folder(wanted: &Path) -> Result<PathBuf, Failure> {
    for number in 1..=MAX_FOLDERS {
        let folder = match number {
            1 => wanted.to_owned(),
            _ => PathBuf::from(format!("{}_{number}", wanted.display())),
        };
        if let Some(parent) = folder.parent() {
            fs::create_dir_all(parent).map_err(|error| cannot("create", parent, &error))?;
        }
        match fs::create_dir(&folder) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(cannot("create", &folder, &error)),
            Ok(()) => return Ok(folder),
        }
    }
    Err(Failure::plain(
        Exit::Failed,
        format!(
            "{} and its numbered variants up to _{MAX_FOLDERS} exist; remove some, or name another folder with --output",
            wanted.display()
        ),
    ))
}

fn only_entry(folder: &Path) -> Result<PathBuf, Failure> {
    let entry = fs::read_dir(folder).and_then(|mut entries| entries.next().transpose());
    match entry {
        Ok(Some(entry)) => Ok(entry.path()),
        Ok(None) => Err(Failure::plain(
            Exit::Failed,
            format!("the node has left no recording in {}", folder.display()),
        )),
        Err(error) => Err(cannot("read", folder, &error)),
    }
}
