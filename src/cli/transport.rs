//! The option `--transport` of the commands that take part in ROS 2.

use clap::{Args, ValueEnum};
use column_twin::ros::{Environment, Transport};

/// How messages travel.
#[derive(Debug, Clone, Copy, Args)]
pub struct TransportArgs {
    /// How messages travel: by DDS, or by Zenoh as rmw_zenoh speaks it
    #[arg(long, value_enum, default_value_t = Name::Dds)]
    transport: Name,
}

/// A transport on the command line.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Name {
    Dds,
    Zenoh,
}

impl TransportArgs {
    /// The environment with this transport.
    pub fn apply(self, environment: Environment) -> Environment {
        Environment {
            transport: match self.transport {
                Name::Dds => Transport::Dds,
                Name::Zenoh => Transport::Zenoh,
            },
            ..environment
        }
    }
}
