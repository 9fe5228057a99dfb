//! `column-twin keystore`: keys, certificates and permissions for DDS security.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueEnum};

use super::failure::{Exit, Failure, printed};
use column_twin::keystore::{
    AUTHORITY_NAME, POLICY_ORIGIN, PlanError, PlannedEnclave, Role, Twins, ZenohSite, plan,
};
use column_twin::ros::security::now;
use column_twin::ros::{Environment, NODE_NAME, RosArguments};
use sros2_keystore::{
    self as keystore, Addition, Creation, DataProtection, DomainRanges, ENCLAVE_DAYS, EnclaveName,
    EnclavePlan, EnclaveSummary, KeystoreError, KeystoreSummary, MAX_DOMAIN_ID, Remedy, Renewal,
    Warning,
};

/// Arguments of `column-twin keystore`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct KeystoreArgs {
    #[command(subcommand)]
    command: KeystoreCommand,
}

const EXAMPLE: &str = "\
Example: a keystore for a twin, a monitor that may only read, and an operator, valid in domain 42
  column-twin keystore create keystore --domain 42
  column-twin keystore show keystore
  export ROS_SECURITY_ENABLE=true ROS_SECURITY_STRATEGY=Enforce ROS_SECURITY_KEYSTORE=$PWD/keystore
  ROS_DOMAIN_ID=42 column-twin run --ros-args --enclave /column_twin

The keystore has the format of SROS 2: `ros2 security` and every ROS 2 node can use it.
Exit codes: 0 done, 1 failed, or an enclave cannot be used (show), 2 bad input or usage.";

#[derive(Debug, Subcommand)]
enum KeystoreCommand {
    /// Make a new keystore
    Create(CreateArgs),
    /// Add an enclave to a keystore
    Add(AddArgs),
    /// Extend the validity of certificates and permissions, and sign edited permissions; keys stay as they are
    Renew(RenewArgs),
    /// Print enclaves, expiry and permissions, and check every enclave as a node does at its start
    Show(ShowArgs),
    /// Print the permissions as a policy file for `ros2 security`
    Policy(PolicyArgs),
    /// Print configurations of Zenoh with the same permissions, of the router or of a session
    Zenoh(ZenohArgs),
}

#[derive(Debug, Args)]
struct CreateArgs {
    /// Folder of the keystore, which must not exist or be empty
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    #[command(flatten)]
    enclaves: EnclaveArgs,
    /// Domains in which it is valid, such as 0, 0-9 or 3,7-9 [default: ROS_DOMAIN_ID, else 0]
    #[arg(long, value_name = "DOMAINS")]
    domain: Option<DomainRanges>,
    /// Days for which the enclaves are valid
    #[arg(long, default_value_t = ENCLAVE_DAYS)]
    days: u32,
    /// Whether payloads are encrypted once more by themselves, as SROS 2 does; messages are encrypted in any case
    #[arg(long, value_enum, default_value = "none")]
    data_protection: DataProtectionArg,
}

#[derive(Debug, Args)]
struct AddArgs {
    /// Folder of the keystore
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// The enclave and its role: twin, monitor or operator
    #[arg(value_name = "NAME=ROLE")]
    enclave: String,
    #[command(flatten)]
    twins: TwinArgs,
    /// Domains in which its permissions are valid [default: those of the governance]
    #[arg(long, value_name = "DOMAINS")]
    domain: Option<DomainRanges>,
    /// Days for which it is valid
    #[arg(long, default_value_t = ENCLAVE_DAYS)]
    days: u32,
}

#[derive(Debug, Args)]
struct RenewArgs {
    /// Folder of the keystore
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// The enclaves [default: all]
    #[arg(value_name = "NAME", conflicts_with = "authority")]
    enclaves: Vec<String>,
    /// Renew the certificate of the authority, too, and everything that it has signed
    #[arg(long)]
    authority: bool,
    /// Days for which the enclaves are valid from now on
    #[arg(long, default_value_t = ENCLAVE_DAYS)]
    days: u32,
}

#[derive(Debug, Args)]
struct ShowArgs {
    /// Folder of the keystore
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Domain for which the enclaves are checked [default: the first one of the governance]
    #[arg(long, value_name = "DOMAIN", value_parser = clap::value_parser!(u16).range(0..=i64::from(MAX_DOMAIN_ID)))]
    domain: Option<u16>,
}

#[derive(Debug, Args)]
struct PolicyArgs {
    #[command(flatten)]
    enclaves: EnclaveArgs,
}

#[derive(Debug, Args)]
struct ZenohArgs {
    /// Folder of the keystore
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Print the configuration of a session with the certificate of this enclave, in the place of that of the router
    #[arg(long, value_name = "NAME")]
    session: Option<String>,
    /// The enclave whose certificate the router has
    #[arg(long, value_name = "NAME", default_value = "/router")]
    router: String,
    /// Where the router listens
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:7447")]
    address: String,
    /// Domain of the nodes [default: ROS_DOMAIN_ID, else 0]
    #[arg(long, value_name = "DOMAIN", value_parser = clap::value_parser!(u16).range(0..=i64::from(MAX_DOMAIN_ID)))]
    domain: Option<u16>,
    #[command(flatten)]
    enclaves: EnclaveArgs,
}

#[derive(Debug, Args)]
struct EnclaveArgs {
    /// An enclave and its role (twin, monitor or operator), may be repeated [default: one for each twin by its name,
    /// /monitor and /operator]
    #[arg(long = "enclave", value_name = "NAME=ROLE", num_args = 1..)]
    enclaves: Vec<String>,
    #[command(flatten)]
    twins: TwinArgs,
}

#[derive(Debug, Args)]
struct TwinArgs {
    /// Namespace of a twin, may be repeated for several twins [default: ROS_NAMESPACE, else /]
    #[arg(long = "namespace", value_name = "NAMESPACE")]
    namespaces: Vec<String>,
    /// Name of the twins' nodes; `--ros-args -r FROM:=TO` renames topics as for the node
    #[arg(long, value_name = "NAME", default_value = NODE_NAME)]
    node_name: String,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum DataProtectionArg {
    /// Encrypted once, as a part of the message
    None,
    /// Encrypted a second time, on their own; RustDDS cannot receive such messages of more than 64 kB
    Encrypt,
}

/// Runs the subcommand.
pub fn run(
    arguments: &KeystoreArgs,
    ros: &RosArguments,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let text = match &arguments.command {
        KeystoreCommand::Create(arguments) => create(arguments, ros)?,
        KeystoreCommand::Add(arguments) => add(arguments, ros)?,
        KeystoreCommand::Renew(arguments) => renew(arguments)?,
        KeystoreCommand::Policy(arguments) => {
            let planned = planned(&arguments.enclaves, ros)?;
            keystore::policy(&plans(&planned), POLICY_ORIGIN)
        }
        KeystoreCommand::Zenoh(arguments) => zenoh(arguments, ros)?,
        KeystoreCommand::Show(arguments) => return show(arguments, out),
    };
    printed(out.write_all(text.as_bytes()))
}

fn create(arguments: &CreateArgs, ros: &RosArguments) -> Result<String, Failure> {
    let planned = planned(&arguments.enclaves, ros)?;
    let domains = match &arguments.domain {
        Some(domains) => domains.clone(),
        None => environment()?.domain_id.into(),
    };
    let folder = &arguments.folder;
    keystore::create(&Creation {
        folder,
        authority: AUTHORITY_NAME,
        enclaves: &plans(&planned),
        domains: &domains,
        data: match arguments.data_protection {
            DataProtectionArg::None => DataProtection::None,
            DataProtectionArg::Encrypt => DataProtection::Encrypt,
        },
        days: arguments.days,
        now: now().as_second(),
    })
    .map_err(failure)?;
    let shown = folder.display();
    let mut text = format!(
        "made a keystore in {shown} for domain {domains}, valid for {} days:\n",
        arguments.days
    );
    for PlannedEnclave { role, plan } in &planned {
        let _ = writeln!(text, "  {:<24} {}", plan.name.as_str(), role.name());
    }
    let _ = write!(
        text,
        "\nKeep {shown}/private on this machine, better still offline: it signs new enclaves.\n\
         Another machine needs only the folder of its enclave; docs/security.md describes how to copy it.\n\
         To use the keystore on this machine:\n  \
         export ROS_SECURITY_ENABLE=true ROS_SECURITY_STRATEGY=Enforce ROS_SECURITY_KEYSTORE={}\n",
        absolute(folder).display()
    );
    for PlannedEnclave { role, plan } in &planned {
        let command = match role {
            Role::Twin => "run",
            Role::Monitor => "watch",
            Role::Operator => "impact --mass 1500 --velocity 10",
        };
        let _ = writeln!(
            text,
            "  column-twin {command} --ros-args --enclave {}",
            plan.name
        );
    }
    Ok(text)
}

fn add(arguments: &AddArgs, ros: &RosArguments) -> Result<String, Failure> {
    let twins = twins(&arguments.twins, ros)?;
    let planned = plan(std::slice::from_ref(&arguments.enclave), &twins);
    let mut text = String::new();
    for PlannedEnclave { role, plan } in &planned.map_err(bad_plan)? {
        keystore::add(&Addition {
            folder: &arguments.folder,
            enclave: plan,
            domains: arguments.domain.as_ref(),
            days: arguments.days,
            now: now().as_second(),
        })
        .map_err(failure)?;
        let _ = writeln!(
            text,
            "added the enclave {} ({}), valid for {} days",
            plan.name,
            role.name(),
            arguments.days
        );
    }
    Ok(text)
}

fn renew(arguments: &RenewArgs) -> Result<String, Failure> {
    let names: Result<Vec<_>, _> = arguments
        .enclaves
        .iter()
        .map(|it| EnclaveName::new(it).map_err(PlanError::from))
        .collect();
    let renewed = keystore::renew(&Renewal {
        folder: &arguments.folder,
        enclaves: &names.map_err(bad_plan)?,
        authority: arguments.authority,
        days: arguments.days,
        now: now().as_second(),
    })
    .map_err(failure)?;
    let names: Vec<_> = renewed.iter().map(EnclaveName::as_str).collect();
    let authority = if arguments.authority {
        "the authority's certificate and the governance, and for "
    } else {
        "for "
    };
    Ok(format!(
        "renewed {authority}{} days: {}\nCopy the folders to the machines that use them, and restart the programs there.\n",
        arguments.days,
        names.join(", ")
    ))
}

fn zenoh(arguments: &ZenohArgs, ros: &RosArguments) -> Result<String, Failure> {
    let named = |name: &str| EnclaveName::new(name).map_err(|error| bad_plan(error.into()));
    let site = ZenohSite {
        keystore: &absolute(&arguments.folder),
        address: &arguments.address,
        domain_id: match arguments.domain {
            Some(domain_id) => domain_id,
            None => environment()?.domain_id,
        },
    };
    match &arguments.session {
        Some(session) => Ok(site.session(&named(session)?)),
        None => {
            let planned = planned(&arguments.enclaves, ros)?;
            Ok(site.router(&named(&arguments.router)?, &planned))
        }
    }
}

fn show(arguments: &ShowArgs, out: &mut impl Write) -> Result<(), Failure> {
    let folder = &arguments.folder;
    let summary = keystore::inspect(folder, arguments.domain, now()).map_err(failure)?;
    printed(out.write_all(described(folder, &summary).as_bytes()))?;
    if summary.is_usable() {
        return Ok(());
    }
    let broken = summary.enclaves.iter().filter(|it| it.state.is_err());
    let names: Vec<_> = broken.map(|it| it.name.as_str()).collect();
    Err(Failure::plain(
        Exit::Failed,
        format!(
            "no node can use {}; the faults are listed above",
            names.join(", ")
        ),
    ))
}

fn described(folder: &Path, summary: &KeystoreSummary) -> String {
    let mut text = format!(
        "keystore    {}\ndomains     {}; checked for domain {}\n",
        folder.display(),
        summary.domains,
        summary.checked_domain
    );
    for authority in &summary.authorities {
        let _ = writeln!(text, "authority   signs {authority}");
    }
    if !summary.can_sign {
        text += "            its key is not here, so this copy cannot add or renew enclaves\n";
    }
    for warning in &summary.warnings {
        let _ = writeln!(text, "warning     {}", advised(warning));
    }
    for enclave in &summary.enclaves {
        let _ = writeln!(text, "\n{}", enclave.name);
        describe_enclave(enclave, &mut text);
    }
    if summary.enclaves.is_empty() {
        text += "no enclave\n";
    }
    text
}

fn describe_enclave(enclave: &EnclaveSummary, text: &mut String) {
    let mut line = |what: &str, value: &str| {
        let _ = writeln!(text, "  {what:<12}{value}");
    };
    match &enclave.state {
        Ok(usable) => {
            let (file, until) = usable.first_end;
            line("subject", &usable.subject);
            line("valid", &format!("until {until} ({file} expires first)"));
            line("protection", &usable.protection);
        }
        Err(faults) => faults.iter().for_each(|fault| line("fault", fault)),
    }
    for warning in &enclave.warnings {
        line("warning", &advised(warning));
    }
    for (mut what, names) in allowed(enclave) {
        for row in rows(&names) {
            line(what, &row);
            what = "";
        }
    }
}

/// What an enclave may do, by the names of ROS: a service is a pair of DDS topics. What is neither a topic nor a service of ROS
/// stands as it is.
fn allowed(enclave: &EnclaveSummary) -> [(&'static str, BTreeSet<String>); 5] {
    let (mut publish, mut subscribe) = (enclave.publish.clone(), enclave.subscribe.clone());
    let service = |topic: &str, before: &str, after: &str| {
        let name = topic.strip_prefix(before)?.strip_suffix(after)?;
        name.starts_with('/').then(|| name.to_owned())
    };
    let mut pairs = |publish: &mut BTreeSet<String>, sent: [&str; 2], received: [&str; 2]| {
        let names: BTreeSet<_> = (publish.iter())
            .filter_map(|topic| service(topic, sent[0], sent[1]))
            .filter(|name| subscribe.remove(&format!("{}{name}{}", received[0], received[1])))
            .collect();
        for name in &names {
            publish.remove(&format!("{}{name}{}", sent[0], sent[1]));
        }
        names
    };
    let (request, reply) = (["rq", "Request"], ["rr", "Reply"]);
    let calls = pairs(&mut publish, request, reply);
    let offers = pairs(&mut publish, reply, request);
    let topics = |all: &mut BTreeSet<String>| -> BTreeSet<String> {
        let names = all.iter().filter_map(|topic| service(topic, "rt", ""));
        let names: BTreeSet<_> = names.collect();
        all.retain(|topic| service(topic, "rt", "").is_none());
        names
    };
    let (sends, reads) = (topics(&mut publish), topics(&mut subscribe));
    let others = publish.union(&subscribe).cloned().collect();
    [
        ("sends", sends),
        ("reads", reads),
        ("calls", calls),
        ("offers", offers),
        ("DDS topics", others),
    ]
}

/// Names in rows that fit into a terminal.
fn rows(names: &BTreeSet<String>) -> Vec<String> {
    const WIDTH: usize = 90;
    let mut rows = Vec::<String>::new();
    for name in names {
        if let Some(row) = rows.last_mut()
            && row.len() + name.len() < WIDTH
        {
            *row += &format!(" {name}");
        } else {
            rows.push(name.clone());
        }
    }
    rows
}

fn planned(arguments: &EnclaveArgs, ros: &RosArguments) -> Result<Vec<PlannedEnclave>, Failure> {
    let twins = twins(&arguments.twins, ros)?;
    plan(&arguments.enclaves, &twins).map_err(bad_plan)
}

fn plans(planned: &[PlannedEnclave]) -> Vec<EnclavePlan> {
    planned.iter().map(|it| it.plan.clone()).collect()
}

fn twins(arguments: &TwinArgs, ros: &RosArguments) -> Result<Twins, Failure> {
    let namespaces = match arguments.namespaces.as_slice() {
        [] => vec![environment()?.namespace],
        given => given.to_vec(),
    };
    let twins = Twins::new(&namespaces, &arguments.node_name, &ros.remap_rules);
    twins.map_err(|error| Failure::plain(Exit::BadInput, error))
}

/// Domain and namespace of the environment. The settings of security are not read: they may name a keystore that is only being
/// made.
fn environment() -> Result<Environment, Failure> {
    let relevant = ["ROS_DOMAIN_ID", "ROS_NAMESPACE"];
    Environment::from_variables(|name| {
        let value = relevant.contains(&name).then(|| std::env::var(name).ok());
        value.flatten()
    })
    .map_err(|error| Failure::plain(Exit::BadInput, error))
}

fn absolute(folder: &Path) -> PathBuf {
    std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf())
}

fn failure(error: KeystoreError) -> Failure {
    let exit = match error.is_bad_input() {
        true => Exit::BadInput,
        false => Exit::Failed,
    };
    let text = match error.remedy() {
        Some(remedy) => format!("{error}: {}", command(&remedy)),
        None => error.to_string(),
    };
    Failure::plain(exit, text)
}

fn bad_plan(error: PlanError) -> Failure {
    Failure::plain(Exit::BadInput, error)
}

fn advised(warning: &Warning) -> String {
    match &warning.remedy {
        Some(remedy) => format!("{}: {}", warning.text, command(remedy)),
        None => warning.text.clone(),
    }
}

/// The command that does it.
fn command(remedy: &Remedy) -> String {
    let rest = match remedy {
        Remedy::Create(folder) => format!("create {}", folder.display()),
        Remedy::Add(folder) => format!("add {} /NAME=monitor", folder.display()),
        Remedy::Renew(enclave) => format!("renew DIR {enclave}"),
        Remedy::RenewAuthority => "renew DIR --authority".to_owned(),
    };
    format!("column-twin keystore {rest}")
}
