//! Names of enclaves, and which enclaves a keystore for some twins needs.

use std::fmt;
use std::path::PathBuf;

use crate::ros::security::{DEFAULT_ENCLAVE, enclave_name};
use crate::ros::{NameError, Names, RemapRule};

use super::access::Role;
use super::error::KeystoreError;

/// Name of an enclave, such as `/monitor` or `/garage/a3/column_twin`: it begins with a slash and has at least one part.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct EnclaveName(String);

impl EnclaveName {
    /// Most characters: the name is the common name of a certificate, which has at most 64.
    const MAX_LENGTH: usize = 64;

    /// Checks the name.
    ///
    /// # Errors
    /// It is not the name of an enclave, it is that of the whole keystore, or too long for a certificate.
    pub fn new(name: &str) -> Result<Self, KeystoreError> {
        let name = enclave_name("the enclave", name)?;
        if name == DEFAULT_ENCLAVE {
            return Err(KeystoreError::NoName);
        }
        if name.len() > Self::MAX_LENGTH {
            return Err(KeystoreError::LongName {
                found: name.len(),
                max: Self::MAX_LENGTH,
            });
        }
        Ok(Self(name))
    }

    /// The name as text, with its slash.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The last part of the name.
    #[must_use]
    pub fn last(&self) -> &str {
        self.0.rsplit('/').next().unwrap_or_default()
    }

    /// The folder of the enclave below `enclaves/`.
    #[must_use]
    pub fn folder(&self) -> PathBuf {
        self.0.split('/').skip(1).collect()
    }

    /// The node with the name of the enclave.
    pub(super) fn node(&self) -> Result<Names, NameError> {
        let (namespace, node) = self.0.rsplit_once('/').unwrap_or_default();
        let namespace = if namespace.is_empty() { "/" } else { namespace };
        Names::new(namespace, node, &[])
    }
}

impl fmt::Display for EnclaveName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

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

/// An enclave to be made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EnclavePlan {
    /// Its name.
    pub name: EnclaveName,
    /// What it is for.
    pub role: Role,
    /// The twins that it is about.
    pub twins: Vec<Names>,
}

/// The enclaves for some twins, by texts such as `/control_room=monitor`; without any, one for each twin by its name, and
/// `/monitor` and `/operator` for all of them. Without a role, the name tells it: that of a twin, or a last part `monitor` or
/// `operator`.
///
/// # Errors
/// A name or role is invalid, or an enclave is named twice.
pub fn plan(wanted: &[String], twins: &Twins) -> Result<Vec<EnclavePlan>, KeystoreError> {
    let mut plans: Vec<EnclavePlan> = Vec::new();
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
        let role = role.ok_or_else(|| KeystoreError::Role(text.clone()))?;
        if plans.iter().any(|plan| plan.name == name) {
            return Err(KeystoreError::Twice(name));
        }
        let own = match role {
            Role::Twin => twins.of_enclave(&name),
            Role::Monitor | Role::Operator => twins.0.clone(),
        };
        plans.push(EnclavePlan {
            name,
            role,
            twins: own,
        });
    }
    Ok(plans)
}
