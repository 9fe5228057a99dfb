//! The arguments after `--ros-args`, as in rcl (<https://design.ros2.org/articles/ros_command_line_arguments.html>).
//!
//! The crate `ros2args` is no replacement: it keeps `-p` and `--params-file` in separate lists, so that the last one cannot
//! win, stops at the first error, reads `rostopic://a:=b` as a rule for the node `rostopic`, and rejects `--log-file-name`.

use std::ffi::OsString;
use std::path::PathBuf;

use sros2_keystore::{EnclaveNameError, enclave_name};

use super::names::{RemapRule, RemapTarget};

/// Begins a section of ROS arguments.
const BEGIN: &str = "--ros-args";

/// Ends the section; the program's own arguments follow.
const END: &str = "--";

/// The ROS arguments of all sections together.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RosArguments {
    /// `-r`, `--remap`, in their order.
    pub remap_rules: Vec<RemapRule>,
    /// `-p`, `--param` and `--params-file` in their order: as in rcl, the last one wins, whether a file or not.
    pub parameters: Vec<GivenParameters>,
    /// `--log-level`; the last one applies.
    pub log_level: Option<LogLevel>,
    /// `--log-level name:=level`: levels of single loggers.
    pub logger_levels: Vec<(String, LogLevel)>,
    /// Whether log messages are published on `/rosout`; `None`: the default, which is yes.
    pub rosout: Option<bool>,
    /// Whether log messages are shown on the terminal; `None`: the default, which is yes.
    pub stdout: Option<bool>,
    /// `-e`, `--enclave`; the last one applies.
    pub enclave: Option<String>,
    /// ROS arguments that have no effect on this node, to be logged at the start.
    pub without_effect: Vec<String>,
}

/// What `-p`, `--param` or `--params-file` says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum GivenParameters {
    /// `name:=value` or `node:name:=value`, as it is written.
    Override(String),
    /// A parameter file.
    File(PathBuf),
}

/// Minimum level of log messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogLevel {
    /// `debug`
    Debug,
    /// `info`
    Info,
    /// `warn`
    Warn,
    /// `error`
    Error,
    /// `fatal`
    Fatal,
}

/// Errors in ROS arguments.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ArgumentError {
    /// The value is missing.
    #[error("{0} requires a value; see `ros2 run --help`")]
    NoValue(String),
    /// The argument is unknown.
    #[error(
        "{0} is not a ROS argument; use -r, -p, --params-file or --log-level, and put the program's own arguments before \
         --ros-args or after `--`"
    )]
    Unknown(String),
    /// The remapping rule is invalid.
    #[error(
        "-r {0}: expected [node:]from:=to, such as column_state:=/monitor/state or __ns:=/garage"
    )]
    RemapRule(String),
    /// The level is invalid.
    #[error("--log-level {0}: expected debug, info, warn, error or fatal, or logger:=level")]
    LogLevel(String),
    /// The enclave is invalid.
    #[error(transparent)]
    Enclave(#[from] EnclaveNameError),
    /// The argument is not text.
    #[error("{0:?} is not UTF-8 text")]
    NotText(OsString),
}

impl RosArguments {
    /// Separates the program's own arguments, which are returned first, from the ROS arguments.
    ///
    /// # Errors
    /// All faults, argument by argument.
    pub fn split(
        arguments: impl IntoIterator<Item = OsString>,
    ) -> Result<(Vec<OsString>, Self), Vec<ArgumentError>> {
        let mut own = Vec::new();
        let mut ros = Self::default();
        let mut faults = Vec::new();
        let mut arguments = arguments.into_iter();
        while let Some(argument) = arguments.next() {
            if argument == BEGIN {
                ros.take_section(&mut arguments, &mut faults);
            } else {
                own.push(argument);
            }
        }
        if faults.is_empty() {
            Ok((own, ros))
        } else {
            Err(faults)
        }
    }

    /// Whether an argument is one of those that belong after `--ros-args`.
    #[must_use]
    pub fn knows(argument: &str) -> bool {
        let mut value = std::iter::once(OsString::from("a:=b"));
        let taken = Self::default().take_one(argument, &mut value);
        !matches!(taken, Err(ArgumentError::Unknown(_)))
    }

    /// Reads a section up to `--` or the end.
    fn take_section(
        &mut self,
        arguments: &mut impl Iterator<Item = OsString>,
        faults: &mut Vec<ArgumentError>,
    ) {
        while let Some(argument) = arguments.next() {
            let taken = match argument.into_string() {
                Ok(argument) if argument == END => return,
                // A section may begin within a section.
                Ok(argument) if argument == BEGIN => Ok(()),
                Ok(argument) => self.take_one(&argument, arguments),
                Err(argument) => Err(ArgumentError::NotText(argument)),
            };
            faults.extend(taken.err());
        }
    }

    fn take_one(
        &mut self,
        argument: &str,
        rest: &mut impl Iterator<Item = OsString>,
    ) -> Result<(), ArgumentError> {
        let mut value = || match rest.next() {
            Some(value) => value.into_string().map_err(ArgumentError::NotText),
            None => Err(ArgumentError::NoValue(argument.to_owned())),
        };
        match argument {
            "-r" | "--remap" => self.remap_rules.push(remap_rule(&value()?)?),
            "-p" | "--param" => self.parameters.push(GivenParameters::Override(value()?)),
            "--params-file" => self.parameters.push(GivenParameters::File(value()?.into())),
            "--log-level" => self.take_log_level(&value()?)?,
            "--enable-rosout-logs" => self.rosout = Some(true),
            "--disable-rosout-logs" => self.rosout = Some(false),
            "--enable-stdout-logs" => self.stdout = Some(true),
            "--disable-stdout-logs" => self.stdout = Some(false),
            "-e" | "--enclave" => self.enclave = Some(enclave_name("--enclave", &value()?)?),
            "--log-config-file" | "--log-file-name" => {
                let value = value()?;
                self.without_effect.push(format!("{argument} {value}"));
            }
            "--enable-external-lib-logs" | "--disable-external-lib-logs" => {
                self.without_effect.push(argument.to_owned());
            }
            _ => return Err(ArgumentError::Unknown(argument.to_owned())),
        }
        Ok(())
    }

    fn take_log_level(&mut self, text: &str) -> Result<(), ArgumentError> {
        let wrong = || ArgumentError::LogLevel(text.to_owned());
        match text.split_once(":=") {
            Some(("", _)) => return Err(wrong()),
            Some((logger, level)) => {
                let level = LogLevel::parse(level).ok_or_else(wrong)?;
                self.logger_levels.push((logger.to_owned(), level));
            }
            None => self.log_level = Some(LogLevel::parse(text).ok_or_else(wrong)?),
        }
        Ok(())
    }

    /// The level of the logger with this name: its own, or else the general one.
    #[must_use]
    pub fn level_of(&self, logger: &str) -> LogLevel {
        let own = self.logger_levels.iter().rev();
        own.into_iter()
            .find(|(name, _)| name == logger)
            .map(|(_, level)| *level)
            .or(self.log_level)
            .unwrap_or(LogLevel::Info)
    }
}

impl LogLevel {
    /// Accepts upper and lower case, as rcl does.
    fn parse(text: &str) -> Option<Self> {
        match text.to_ascii_lowercase().as_str() {
            "debug" => Some(Self::Debug),
            "info" => Some(Self::Info),
            "warn" => Some(Self::Warn),
            "error" => Some(Self::Error),
            "fatal" => Some(Self::Fatal),
            _ => None,
        }
    }
}

/// Parses `[node:]from:=to`, where `from` may begin with `rostopic://` or `rosservice://`, or be `__node`, `__name` or
/// `__ns`.
fn remap_rule(text: &str) -> Result<RemapRule, ArgumentError> {
    let wrong = || ArgumentError::RemapRule(text.to_owned());
    let (from, to) = text.split_once(":=").ok_or_else(wrong)?;
    let (node, from) = match from.split_once(':') {
        Some((_, rest)) if rest.starts_with("//") => (None, from),
        Some((node, from)) => (Some(node), from),
        None => (None, from),
    };
    let (target, from) = match from {
        "__node" | "__name" => (RemapTarget::NodeName, ""),
        "__ns" => (RemapTarget::Namespace, ""),
        _ => match (
            from.strip_prefix("rostopic://"),
            from.strip_prefix("rosservice://"),
        ) {
            (Some(from), _) => (RemapTarget::Topic, from),
            (_, Some(from)) => (RemapTarget::Service, from),
            _ => (RemapTarget::TopicOrService, from),
        },
    };
    let special = matches!(target, RemapTarget::NodeName | RemapTarget::Namespace);
    if to.is_empty() || (from.is_empty() && !special) || node == Some("") {
        return Err(wrong());
    }
    Ok(RemapRule {
        node: node.map(str::to_owned),
        target,
        from: from.to_owned(),
        to: to.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    type Split = Result<(Vec<OsString>, RosArguments), Vec<ArgumentError>>;

    fn split(line: &str) -> Split {
        RosArguments::split(line.split_whitespace().map(OsString::from))
    }

    fn rule(text: &str) -> (Option<String>, RemapTarget, String, String) {
        let rule = remap_rule(text).expect(text);
        (rule.node, rule.target, rule.from, rule.to)
    }

    #[test]
    fn arguments_from_launch_are_read() {
        let (own, ros) = split(
            "run --config c.yaml --ros-args -r __node:=pillar -r __ns:=/garage --params-file /tmp/p.yaml \
             -p top.load:=2.0e6 --log-level column_twin:=debug --log-level WARN -- --record",
        )
        .expect("correct");
        assert_eq!(own, ["run", "--config", "c.yaml", "--record"]);
        assert_eq!(ros.remap_rules.len(), 2);
        let expected = [
            GivenParameters::File("/tmp/p.yaml".into()),
            GivenParameters::Override("top.load:=2.0e6".to_owned()),
        ];
        assert_eq!(ros.parameters, expected);
        assert_eq!(ros.level_of("column_twin"), LogLevel::Debug);
        assert_eq!(ros.level_of("another"), LogLevel::Warn);
    }

    #[test]
    fn several_sections_add_up() {
        let (own, ros) =
            split("--ros-args -r a:=b -- x --ros-args -r c:=d --ros-args").expect("correct");
        assert_eq!(own, ["x"]);
        assert_eq!(ros.remap_rules.len(), 2);
        assert_eq!(split("").expect("correct").1, RosArguments::default());
        assert_eq!(split("run -- x").expect("correct").0, ["run", "--", "x"]);
    }

    #[test]
    fn rules_are_read_as_in_rcl() {
        let text = str::to_owned;
        for (given, node, target, from, to) in [
            ("a:=b", None, RemapTarget::TopicOrService, "a", "b"),
            (
                "~/a:=/b/c",
                None,
                RemapTarget::TopicOrService,
                "~/a",
                "/b/c",
            ),
            ("__node:=n", None, RemapTarget::NodeName, "", "n"),
            ("__name:=n", None, RemapTarget::NodeName, "", "n"),
            ("__ns:=/n", None, RemapTarget::Namespace, "", "/n"),
            ("x:__ns:=/n", Some("x"), RemapTarget::Namespace, "", "/n"),
            ("x:a:=b", Some("x"), RemapTarget::TopicOrService, "a", "b"),
            ("rostopic://a:=b", None, RemapTarget::Topic, "a", "b"),
            (
                "rosservice://~/a:=b",
                None,
                RemapTarget::Service,
                "~/a",
                "b",
            ),
        ] {
            assert_eq!(
                rule(given),
                (node.map(text), target, text(from), text(to)),
                "{given}"
            );
        }
        for wrong in ["a", "a=b", ":=b", "a:=", "x::=b", ":a:=b"] {
            assert!(remap_rule(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn all_faults_are_reported_at_once() {
        let faults =
            split("--ros-args -r a=b --log-level loud --velocity 3 -p").expect_err("four faults");
        let words: Vec<_> = faults.iter().map(ToString::to_string).collect();
        assert!(
            words[0].starts_with("-r a=b: expected [node:]from:=to"),
            "{words:?}"
        );
        assert!(
            words[1].starts_with("--log-level loud: expected debug, info"),
            "{words:?}"
        );
        assert!(
            words[2].starts_with("--velocity is not a ROS argument"),
            "{words:?}"
        );
        assert!(words[4].starts_with("-p requires a value"), "{words:?}");
    }

    #[test]
    fn arguments_that_need_ros_args_are_known() {
        for argument in ["-p", "--param", "--params-file", "-r", "--log-level", "-e"] {
            assert!(RosArguments::knows(argument), "{argument}");
        }
        for argument in ["--config", "-c", "-x", "top.load:=1.0", ""] {
            assert!(!RosArguments::knows(argument), "{argument}");
        }
    }

    /// What launch files and people write, and what they mistype.
    #[test]
    fn forty_two_sets_of_ros_args_are_read_or_rejected_as_in_rcl() {
        let read = [
            "",
            "--ros-args",
            "--ros-args --",
            "--ros-args -- --ros-args",
            "--ros-args -r a:=b",
            "--ros-args --remap a:=b",
            "--ros-args -r /a:=/b",
            "--ros-args -r ~/a:=~/b",
            "--ros-args -r __node:=n",
            "--ros-args -r __name:=n",
            "--ros-args -r __ns:=/n",
            "--ros-args -r x:__ns:=/n",
            "--ros-args -r rostopic://a:=b -r rosservice://a:=c",
            "--ros-args -p a:=1",
            "--ros-args --param a:=1",
            "--ros-args -p a:=",
            "--ros-args -p x:a:=1.5",
            "--ros-args -p a:=[1.0,2.0] -p b:='text'",
            "--ros-args --params-file a.yaml",
            "--ros-args --params-file a.yaml --params-file b.yaml -p c:=true",
            "--ros-args --log-level debug",
            "--ros-args --log-level DEBUG",
            "--ros-args --log-level a:=warn --log-level b.c:=fatal",
            "--ros-args -e /one",
            "--ros-args --enclave /",
            "--ros-args --disable-rosout-logs",
            "--ros-args --enable-rosout-logs",
            "--ros-args --disable-stdout-logs --disable-external-lib-logs",
            "--ros-args --log-file-name x",
            "run --config c.yaml --ros-args -p a:=1 -- --record",
        ];
        let rejected = [
            "--ros-args -r",
            "--ros-args -r a",
            "--ros-args -r a:=",
            "--ros-args -r :=b",
            "--ros-args -p",
            "--ros-args -r x::=b",
            "--ros-args --params-file",
            "--ros-args --log-level",
            "--ros-args --log-level loud",
            "--ros-args -e twin",
            "--ros-args --no-such-argument",
            "--ros-args stray",
        ];
        assert_eq!(read.len() + rejected.len(), 42);
        for line in read {
            let read = split(line);
            assert!(read.is_ok(), "{line}: {read:?}");
        }
        for line in rejected {
            assert!(split(line).is_err(), "{line}");
        }
    }

    #[test]
    fn arguments_without_effect_are_kept() {
        let (_, ros) =
            split("--ros-args --disable-rosout-logs --log-file-name x").expect("correct");
        assert_eq!(ros.without_effect, ["--log-file-name x"]);
        assert_eq!(ros.rosout, Some(false));
    }

    #[test]
    fn the_last_enclave_applies_and_must_be_a_full_name() {
        let (_, ros) = split("--ros-args -e /one --enclave /garage/two").expect("correct");
        assert_eq!(ros.enclave.as_deref(), Some("/garage/two"));
        let faults = split("--ros-args -e twin").expect_err("relative");
        assert!(
            faults[0]
                .to_string()
                .starts_with("--enclave: expected the full name"),
            "{faults:?}"
        );
    }
}
