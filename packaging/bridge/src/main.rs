//! A Zenoh router with the bridge between DDS and Zenoh, as one program: what `zenoh-bridge-ros2dds` is, from the crates
//! registry, and with a configuration without the plugin `ros2dds` what `zenohd` is.
//!
//! ```text
//! column-twin-bridge -c config/zenoh/site.json5 -d 7 -n /garage -e tcp/192.0.2.1:7447
//! ```
//!
//! The options are those of `zenoh-bridge-ros2dds`, of which it has the ones that a site needs.
//!
//! It runs until SIGINT or SIGTERM. The log goes to the standard output; `RUST_LOG` chooses what it contains.

use std::path::PathBuf;
use std::process::ExitCode;

use tokio::signal::unix::{SignalKind, signal};
use zenoh::Config;
use zenoh::internal::plugins::PluginsManager;
use zenoh::internal::runtime::RuntimeBuilder;
use zenoh_plugin_ros2dds::ROS2Plugin;

const USAGE: &str = "\
usage: column-twin-bridge -c FILE [-e ENDPOINT] [-l ENDPOINT] [-d DOMAIN] [-n NAMESPACE]
  -c FILE       configuration of Zenoh, with the plugin ros2dds for a bridge, without it for a router
  -e ENDPOINT   connect to this router, such as tcp/192.0.2.1:7447, instead of the ones in FILE
  -l ENDPOINT   listen here instead of where FILE says
  -d DOMAIN     ROS_DOMAIN_ID of the site
  -n NAMESPACE  what the names of the site begin with for all others, such as /garage";
/// Name of the bridge's part of the configuration, under `plugins`.
const BRIDGE: &str = "ros2dds";
const FAILURE: u8 = 1;
const INVALID_INPUT: u8 = 2;

/// The exit code and what to tell the user.
struct Failure(u8, String);

fn main() -> ExitCode {
    let started = configuration(std::env::args().skip(1)).and_then(run);
    match started {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure(code, message)) => {
            eprintln!("column-twin-bridge: {message}");
            ExitCode::from(code)
        }
    }
}

/// The configuration that the arguments name, with what they replace in it.
fn configuration(mut arguments: impl Iterator<Item = String>) -> Result<Config, Failure> {
    let invalid = |message: String| Failure(INVALID_INPUT, message);
    let mut file = None;
    let mut replacements = Vec::new();
    while let Some(option) = arguments.next() {
        let value = arguments
            .next()
            .ok_or_else(|| invalid(format!("a value is missing after {option:?}\n{USAGE}")))?;
        let (key, value) = match option.as_str() {
            "-c" => {
                file = Some(PathBuf::from(value));
                continue;
            }
            "-e" => ("connect/endpoints", format!("[{value:?}]")),
            "-l" => ("listen/endpoints", format!("[{value:?}]")),
            "-d" => ("plugins/ros2dds/domain", value),
            "-n" => ("plugins/ros2dds/namespace", format!("{value:?}")),
            _ => return Err(invalid(format!("unknown option {option:?}\n{USAGE}"))),
        };
        replacements.push((key, value));
    }
    let file = file.ok_or_else(|| invalid(format!("-c FILE is missing\n{USAGE}")))?;
    let mut config = Config::from_file(&file)
        .map_err(|error| invalid(format!("cannot read {}: {error}", file.display())))?;
    for (key, value) in replacements {
        config
            .insert_json5(key, &value)
            .map_err(|error| invalid(format!("cannot set {key} to {value}: {error}")))?;
    }
    Ok(config)
}

/// Runs until a signal ends it.
fn run(config: Config) -> Result<(), Failure> {
    zenoh::init_log_from_env_or("info");
    let failed = |message: String| Failure(FAILURE, message);
    tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .build()
        .map_err(|error| failed(format!("cannot start the threads: {error}")))?
        .block_on(async {
            let mut interrupted = signal(SignalKind::interrupt())
                .map_err(|error| failed(format!("cannot wait for SIGINT: {error}")))?;
            let mut terminated = signal(SignalKind::terminate())
                .map_err(|error| failed(format!("cannot wait for SIGTERM: {error}")))?;
            let bridges = config.get_json(&format!("plugins/{BRIDGE}")).is_ok();
            let mut plugins = PluginsManager::static_plugins_only();
            if bridges {
                plugins.declare_static_plugin::<ROS2Plugin, &str>(BRIDGE, true);
            }
            let mut router = RuntimeBuilder::new(config)
                .plugins_manager(plugins)
                .build()
                .await
                .map_err(|error| failed(format!("cannot build the router: {error}")))?;
            router
                .start()
                .await
                .map_err(|error| failed(format!("cannot start the router: {error}")))?;
            println!(
                "column-twin-bridge: ready, {}",
                if bridges {
                    "with the bridge to DDS"
                } else {
                    "a router only"
                }
            );
            tokio::select! {
                _ = interrupted.recv() => {}
                _ = terminated.recv() => {}
            }
            Ok(())
        })
}
