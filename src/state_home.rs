//! Folders below the state folder of the user (XDG Base Directory Specification 0.8), as parameters name them.
//!
//! A node that is started from another folder has to find the damage again, so the defaults do not depend on the working folder.

use std::env;
use std::ffi::OsString;
use std::path::PathBuf;

/// What a folder begins with that lies below the state folder of the user.
pub const STATE_HOME: &str = "$XDG_STATE_HOME";

/// The folder that a parameter names: below the state folder of the user where it begins with [`STATE_HOME`], otherwise as given.
///
/// The state folder is `XDG_STATE_HOME` of the environment, or `~/.local/state` where that is no absolute path; where the
/// environment names no home either, it is the current folder, see [`without_home`].
#[must_use]
pub fn resolve(folder: &str) -> PathBuf {
    resolved(folder, |name| env::var_os(name))
}

/// A warning where a folder is to lie below the state folder of the user, and the environment names none.
#[must_use]
pub fn without_home(parameter: &str, folder: &str) -> Option<String> {
    below_home(folder)?;
    home(|name| env::var_os(name)).is_none().then(|| {
        let current = env::current_dir().unwrap_or_default();
        format!(
            "{parameter} is {folder}, but neither XDG_STATE_HOME nor HOME names an absolute path, so it is {} below the current folder, {}; \
             a node that is started from another folder does not find it: set one of both, or {parameter}",
            resolve(folder).display(),
            current.display()
        )
    })
}

/// The part of a folder below the state folder of the user; `None` for any other folder.
fn below_home(folder: &str) -> Option<&str> {
    let below = folder.strip_prefix(STATE_HOME)?;
    (below.is_empty() || below.starts_with('/')).then(|| below.trim_start_matches('/'))
}

/// The state folder of the user in an environment; the specification ignores paths that are not absolute.
fn home(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    let absolute = |name| {
        variable(name)
            .map(PathBuf::from)
            .filter(|it| it.is_absolute())
    };
    absolute("XDG_STATE_HOME").or_else(|| absolute("HOME").map(|it| it.join(".local/state")))
}

fn resolved(folder: &str, variable: impl Fn(&str) -> Option<OsString>) -> PathBuf {
    match below_home(folder) {
        Some(below) => home(variable).unwrap_or_default().join(below),
        None => folder.into(),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// As XDG Base Directory Specification 0.8 says: the variable, else `$HOME/.local/state`; relative paths are ignored.
    #[test]
    fn the_state_folder_follows_from_the_environment() {
        for (state_home, home, expected) in [
            (
                Some("/var/lib"),
                Some("/home/a"),
                "/var/lib/column_twin/state",
            ),
            (
                None,
                Some("/home/a"),
                "/home/a/.local/state/column_twin/state",
            ),
            (
                Some(""),
                Some("/home/a"),
                "/home/a/.local/state/column_twin/state",
            ),
            (
                Some("relative"),
                Some("/home/a"),
                "/home/a/.local/state/column_twin/state",
            ),
            (Some("/var/lib"), None, "/var/lib/column_twin/state"),
            // Nothing to go by.
            (None, Some(""), "column_twin/state"),
            (None, None, "column_twin/state"),
        ] {
            let variable = |name: &str| {
                let value = match name {
                    "XDG_STATE_HOME" => state_home,
                    "HOME" => home,
                    other => panic!("asks for {other}"),
                };
                value.map(OsString::from)
            };
            let found = resolved("$XDG_STATE_HOME/column_twin/state", variable);
            assert_eq!(found, Path::new(expected), "{state_home:?} {home:?}");
        }
    }

    #[test]
    fn other_folders_stay_as_given() {
        let none = |name: &str| panic!("asks for {name}");
        for folder in [
            "/var/x",
            "state",
            "a/$XDG_STATE_HOME/b",
            "$XDG_STATE_HOMES/x",
            "$HOME/x",
        ] {
            assert_eq!(resolved(folder, none), Path::new(folder));
        }
        let home = |_: &str| Some(OsString::from("/s"));
        assert_eq!(resolved("$XDG_STATE_HOME", home), Path::new("/s"));
        assert_eq!(resolved("$XDG_STATE_HOME//x", home), Path::new("/s/x"));
    }
}
