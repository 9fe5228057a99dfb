//! Which enclaves a keystore for some twins needs.

use sros2_keystore::{EnclaveName, EnclaveNameError, EnclavePlan};

use ros_node::names::{NameError, Names, RemapRule};

use super::role::{Role, access};

/// The twins that a keystore is for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Twins(pub Vec<Names>);

impl Twins {
    /// Twins of one node name in these namespaces, all with the same remapping rules; without a namespace, in `/`.
    ///
    /// # Errors
    /// A name is invalid.
    pub fn new(
        namespaces: &[String],
        node_name: &str,
        rules: &[RemapRule],
    ) -> Result<Self, NameError> {
        let root = ["/".to_owned()];
        let namespaces = if namespaces.is_empty() {
            &root
        } else {
            namespaces
        };
        let names = namespaces
            .iter()
            .map(|namespace| Names::new(namespace, node_name, rules));
        Ok(Self(names.collect::<Result<_, _>>()?))
    }

    /// The twins that an enclave is about: the one of its name, or else all.
    fn of_enclave(&self, name: &EnclaveName) -> Vec<Names> {
        let own: Vec<Names> = (self.0.iter())
            .filter(|twin| twin.fully_qualified() == name.as_str())
            .cloned()
            .collect();
        if own.is_empty() { self.0.clone() } else { own }
    }
}

/// An enclave to be made, with what it is for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlannedEnclave {
    /// What it is for.
    pub role: Role,
    /// Its name and what it may therefore do.
    pub plan: EnclavePlan,
}

/// Why enclaves cannot be planned.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// An enclave is named twice.
    #[error("the enclave {0} is named twice; name it once, with one role")]
    Twice(String),
    /// A name of an enclave is invalid.
    #[error(transparent)]
    EnclaveName(#[from] EnclaveNameError),
    /// A name of a node, topic or service is invalid.
    #[error(transparent)]
    NodeName(#[from] NameError),
    /// The role is unknown.
    #[error("`{0}` gives the enclave no role; write NAME=twin, NAME=monitor or NAME=operator")]
    Role(String),
}

/// The enclaves for some twins, by texts such as `/control_room=monitor`; without any, one for each twin by its name, and
/// `/monitor` and `/operator` for all of them. Without a role, the name tells it: that of a twin, or a last part `monitor` or
/// `operator`.
///
/// # Errors
/// A name or role is invalid, or an enclave is named twice.
pub fn plan(wanted: &[String], twins: &Twins) -> Result<Vec<PlannedEnclave>, PlanError> {
    let mut plans: Vec<PlannedEnclave> = Vec::new();
    let default: Vec<String> = (twins.0.iter().map(Names::fully_qualified))
        .chain(["/monitor".to_owned(), "/operator".to_owned()])
        .collect();
    let wanted = if wanted.is_empty() { &default } else { wanted };
    for text in wanted {
        let (name, role) = match text.split_once('=') {
            Some((name, role)) => (name, Some(role)),
            None => (text.as_str(), None),
        };
        let name = EnclaveName::new(name)?;
        let role = match role {
            Some(role) => Role::named(role),
            None if twins
                .0
                .iter()
                .any(|it| it.fully_qualified() == name.as_str()) =>
            {
                Some(Role::Twin)
            }
            None => Role::named(name.last()),
        };
        let role = role.ok_or_else(|| PlanError::Role(text.clone()))?;
        if plans.iter().any(|it| it.plan.name == name) {
            return Err(PlanError::Twice(name.to_string()));
        }
        let own = match role {
            Role::Twin => twins.of_enclave(&name),
            Role::Monitor | Role::Operator => twins.0.clone(),
        };
        let access = access(role, &name, &own)?;
        plans.push(PlannedEnclave {
            role,
            plan: EnclavePlan { name, access },
        });
    }
    Ok(plans)
}
