//! Rust types of the messages, written from `msg/` and `srv/`, which are their single source: `src/messages/mod.rs` includes the result.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

use re_ros_msg::MessageSchema;
use re_ros_msg::message_spec::{ArraySize, BuiltInType, ComplexType, Field, Literal, Type};

/// The ROS package of the definitions in `msg/` and `srv/`; those of other packages are in a folder of `msg/deps`.
const PACKAGE: &str = "column_twin_msgs";

/// A number that is not given, or not known.
const NAN: &str = "f64::NAN";

/// Groups of parameters whose names are more than one word, which their fields in `ColumnParameters` do not show.
const LONG_GROUPS: [&str; 1] = ["yield_surface"];

/// One struct: a message, or a half of a service.
struct Definition {
    package: String,
    /// `Message`, `Request` or `Response` of `ros_interface::Part`.
    part: &'static str,
    /// Name of the file without its extension.
    name: String,
    /// The file, from the folder of the package on.
    file: String,
    fields: Vec<Field>,
    constants: Vec<String>,
}

impl Definition {
    /// Name of the struct.
    fn rust_name(&self) -> String {
        match self.part {
            "Message" => self.name.clone(),
            half => format!("{}{half}", self.name),
        }
    }
}

/// All definitions by package and name of the struct.
struct Definitions(BTreeMap<(String, String), Definition>);

fn main() {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo names the folder"));
    for folder in ["msg", "srv"] {
        println!("cargo::rerun-if-changed={folder}");
    }
    let mut all = Definitions(BTreeMap::new());
    for folder in ["msg", "srv"] {
        all.read_folder(&root, folder, PACKAGE);
    }
    for package in entries(&root.join("msg/deps"))
        .iter()
        .filter(|it| it.is_dir())
    {
        let name = package.file_name().and_then(|it| it.to_str());
        let name = name.expect("a package has an ASCII name");
        all.read_folder(&root, &format!("msg/deps/{name}"), name);
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo names the folder"));
    fs::write(out.join("messages.rs"), all.to_rust()).expect("cargo's folder can be written to");
}

/// The files of a folder by name.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries =
        fs::read_dir(folder).unwrap_or_else(|reason| panic!("{}: {reason}", folder.display()));
    let mut all: Vec<_> = entries
        .map(|entry| entry.expect("a readable folder").path())
        .collect();
    all.sort();
    all
}

impl Definitions {
    fn read_folder(&mut self, root: &Path, folder: &str, package: &str) {
        for path in entries(&root.join(folder)) {
            let extension = path.extension().and_then(|it| it.to_str());
            let name = path.file_stem().and_then(|it| it.to_str());
            let (Some(extension @ ("msg" | "srv")), Some(name)) = (extension, name) else {
                continue;
            };
            let text = fs::read_to_string(&path)
                .unwrap_or_else(|reason| panic!("{}: {reason}", path.display()));
            let file = format!("{folder}/{name}.{extension}");
            let mut add = |part, text: &str| self.add(package, part, name, &file, text);
            match format!("\n{text}").split_once("\n---\n") {
                Some((request, response)) => {
                    add("Request", request);
                    add("Response", response);
                }
                None => add("Message", &text),
            }
        }
    }

    fn add(&mut self, package: &str, part: &'static str, name: &str, file: &str, text: &str) {
        let schema = MessageSchema::parse(name, text);
        let spec = schema
            .unwrap_or_else(|reason| panic!("{file}: {reason:#}"))
            .spec;
        let constants = spec.constants.iter().map(|it| {
            let ty = element(&it.ty, package);
            format!("pub const {}: {ty} = {};", it.name, literal(&it.value))
        });
        let definition = Definition {
            package: package.to_owned(),
            part,
            name: name.to_owned(),
            file: file.to_owned(),
            constants: constants.collect(),
            fields: spec.fields,
        };
        let key = (package.to_owned(), definition.rust_name());
        self.0.insert(key, definition);
    }

    /// One module for each package, then the table of all types, those of this program first.
    fn to_rust(&self) -> String {
        let mut text = String::new();
        let mut packages: Vec<_> = self.0.values().map(|it| it.package.as_str()).collect();
        packages.dedup();
        for package in packages {
            let visibility = if package == PACKAGE {
                "pub(super)"
            } else {
                "pub"
            };
            writeln!(text, "/// Types of the ROS package `{package}`.\n#[allow(missing_docs)]\n{visibility} mod {package} {{").unwrap();
            for definition in self.0.values().filter(|it| it.package == package) {
                text += &self.to_struct(definition);
            }
            text += "}\n";
        }
        text += "/// All types that the twin reads or writes, with their dependencies.\npub const INTERFACES: &[&Interface] = &[\n";
        let (ours, others): (Vec<_>, Vec<_>) =
            self.0.values().partition(|it| it.package == PACKAGE);
        for it in ours.into_iter().chain(others) {
            writeln!(
                text,
                "    <{}::{} as Message>::INTERFACE,",
                it.package,
                it.rust_name()
            )
            .unwrap();
        }
        text += "];\n";
        text
    }

    fn to_struct(&self, of: &Definition) -> String {
        let name = of.rust_name();
        let Definition {
            package,
            part,
            file,
            ..
        } = of;
        let is_exact = |ty: &Type| {
            !matches!(
                innermost(ty),
                Type::BuiltIn(BuiltInType::Float32 | BuiltInType::Float64)
            )
        };
        let defaults: Vec<_> = of
            .fields
            .iter()
            .map(|field| default_of(&name, field))
            .collect();
        let mut derived = vec!["Debug", "Clone", "PartialEq"];
        if self.every_field(of, &is_in_place) {
            derived.push("Copy");
        }
        if self.every_field(of, &is_exact) {
            derived.extend(["Eq", "Hash"]);
        }
        if defaults.iter().all(Option::is_none) {
            derived.push("Default");
        }
        let definition =
            format!("include_str!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/{file}\"))");
        let ros_name = match *part {
            "Message" => format!("{package}/msg/{}", of.name),
            half => format!("{half} of {package}/srv/{}", of.name),
        };
        let mut text = format!(
            "/// {ros_name}\n///\n/// ```text\n#[doc = {definition}]\n/// ```\n#[derive({}, ::serde::Serialize, ::serde::Deserialize)]\npub struct {name} {{\n",
            derived.join(", ")
        );
        for field in &of.fields {
            if field.name == "type" {
                text += "    #[serde(rename = \"type\")]\n";
            }
            writeln!(
                text,
                "    pub {}: {},",
                rust_field(field),
                self.rust_type(&field.ty, package)
            )
            .unwrap();
        }
        text += "}\n";
        if !of.constants.is_empty() {
            writeln!(
                text,
                "impl {name} {{\n    {}\n}}",
                of.constants.join("\n    ")
            )
            .unwrap();
        }
        if defaults.iter().any(Option::is_some) {
            writeln!(
                text,
                "impl Default for {name} {{\n    fn default() -> Self {{\n        Self {{"
            )
            .unwrap();
            for (field, value) in of.fields.iter().zip(defaults) {
                let value = value.unwrap_or_else(|| "Default::default()".to_owned());
                writeln!(text, "            {}: {value},", rust_field(field)).unwrap();
            }
            text += "        }\n    }\n}\n";
        }
        if name == "ColumnParameters" {
            text += &entries_of_parameters(of);
        }
        writeln!(
            text,
            "impl super::Message for {name} {{\n    const INTERFACE: &'static super::Interface = \
             &super::Interface::new(\"{package}\", super::Part::{part}, \"{}\", {definition});\n}}",
            of.name
        )
        .unwrap();
        text
    }

    /// Whether this holds for the type of each field, and of each field of those.
    fn every_field(&self, of: &Definition, holds: &impl Fn(&Type) -> bool) -> bool {
        of.fields.iter().all(|field| match innermost(&field.ty) {
            _ if !holds(&field.ty) => false,
            Type::Complex(nested) => self.every_field(self.nested(nested, &of.package), holds),
            _ => true,
        })
    }

    fn nested(&self, nested: &ComplexType, package: &str) -> &Definition {
        let (package, name) = match nested {
            ComplexType::Absolute { package, name } => (package.as_str(), name),
            ComplexType::Relative { name } => (package, name),
        };
        let key = (package.to_owned(), name.clone());
        let found = self.0.get(&key);
        found.unwrap_or_else(|| {
            panic!(
                "expected a definition of {package}/msg/{name} in msg/ or msg/deps; add its file"
            )
        })
    }

    fn rust_type(&self, ty: &Type, package: &str) -> String {
        let Type::Array { ty, size } = ty else {
            return element(ty, package);
        };
        let element = element(ty, package);
        match (size, &**ty) {
            (ArraySize::Fixed(length), _) => format!("[{element}; {length}]"),
            // Numbers are stored in place.
            (ArraySize::Bounded(most), Type::BuiltIn(it))
                if !matches!(it, BuiltInType::String(_)) =>
            {
                format!("::ros_interface::BoundedSequence<{element}, {most}>")
            }
            _ => format!("::std::vec::Vec<{element}>"),
        }
    }
}

/// The type of a field or an element that is no array.
fn element(ty: &Type, package: &str) -> String {
    match ty {
        Type::BuiltIn(BuiltInType::Bool) => "bool".to_owned(),
        Type::BuiltIn(BuiltInType::Byte | BuiltInType::Char | BuiltInType::UInt8) => {
            "u8".to_owned()
        }
        Type::BuiltIn(BuiltInType::Int8) => "i8".to_owned(),
        Type::BuiltIn(BuiltInType::Int16) => "i16".to_owned(),
        Type::BuiltIn(BuiltInType::Int32) => "i32".to_owned(),
        Type::BuiltIn(BuiltInType::Int64) => "i64".to_owned(),
        Type::BuiltIn(BuiltInType::UInt16) => "u16".to_owned(),
        Type::BuiltIn(BuiltInType::UInt32) => "u32".to_owned(),
        Type::BuiltIn(BuiltInType::UInt64) => "u64".to_owned(),
        Type::BuiltIn(BuiltInType::Float32) => "f32".to_owned(),
        Type::BuiltIn(BuiltInType::Float64) => "f64".to_owned(),
        Type::BuiltIn(BuiltInType::String(_)) => "::std::string::String".to_owned(),
        Type::BuiltIn(BuiltInType::WString(_)) => panic!(
            "{package}: expected no wstring, whose characters have 2 or 4 bytes, depending on the vendor"
        ),
        Type::Complex(ComplexType::Absolute { package, name }) => {
            format!("super::{package}::{name}")
        }
        Type::Complex(ComplexType::Relative { name }) => name.clone(),
        Type::Array { .. } => panic!("{package}: expected no array of arrays"),
    }
}

fn innermost(ty: &Type) -> &Type {
    match ty {
        Type::Array { ty, .. } => innermost(ty),
        other => other,
    }
}

/// Whether a field is copied with its struct: it is neither a text nor a sequence.
fn is_in_place(ty: &Type) -> bool {
    match ty {
        Type::Array {
            size: ArraySize::Bounded(_) | ArraySize::Unbounded,
            ..
        } => false,
        _ => !matches!(innermost(ty), Type::BuiltIn(BuiltInType::String(_))),
    }
}

/// The name of a field in Rust, where `type` is a keyword.
fn rust_field(field: &Field) -> &str {
    match field.name.as_str() {
        "type" => "kind",
        name => name,
    }
}

/// What a field starts with, other than zero, an empty text, or nothing.
fn default_of(of: &str, field: &Field) -> Option<String> {
    if let Some(value) = &field.default {
        return Some(literal(value));
    }
    let means_unknown = match of {
        // Leaves all parameters unchanged.
        "ColumnParameters" => true,
        // Leaves all optional values to the parameters; the velocity must be given, and the mass of a rigid vehicle.
        "ImpactEvent" => !matches!(field.name.as_str(), "mass" | "velocity"),
        // That there is none.
        "SecondOpinion" => true,
        _ => false,
    };
    match &field.ty {
        _ if !means_unknown => None,
        Type::BuiltIn(BuiltInType::Float64) => Some(NAN.to_owned()),
        Type::Array {
            ty,
            size: ArraySize::Fixed(length),
        } if **ty == Type::BuiltIn(BuiltInType::Float64) => Some(format!("[{NAN}; {length}]")),
        Type::BuiltIn(BuiltInType::UInt8)
            if matches!(field.name.as_str(), "outcome" | "action") =>
        {
            Some(format!(
                "ImpactReport::{}_UNKNOWN",
                field.name.to_uppercase()
            ))
        }
        _ => None,
    }
}

/// All parameters of the message with their names in the table of parameters, where a dot separates group and name.
fn entries_of_parameters(of: &Definition) -> String {
    let mut text = "impl ColumnParameters {\n    /// All parameters with their names, in the order of the message.\n    pub fn entries(&self) \
         -> impl Iterator<Item = (&'static str, crate::messages::column_twin_msgs::ParameterEntry<'_>)> {\n        use crate::messages::column_twin_msgs::ParameterEntry::{Number, \
         Text};\n        [\n"
        .to_owned();
    for field in &of.fields {
        let entry = match &field.ty {
            Type::BuiltIn(BuiltInType::Float64) => format!("Number(self.{})", field.name),
            Type::BuiltIn(BuiltInType::String(_)) if field.name != "column_id" => {
                format!("Text(&self.{})", field.name)
            }
            _ => continue,
        };
        let group = LONG_GROUPS
            .iter()
            .find(|it| field.name.starts_with(*it))
            .map(|it| it.len());
        let (group, name) = field.name.split_at(
            group
                .or_else(|| field.name.find('_'))
                .expect("group and name"),
        );
        writeln!(text, "            (\"{group}.{}\", {entry}),", &name[1..]).unwrap();
    }
    text += "        ]\n        .into_iter()\n    }\n}\n";
    text
}

fn literal(value: &Literal) -> String {
    match value {
        Literal::Bool(value) => value.to_string(),
        Literal::Int(value) => value.to_string(),
        Literal::UInt(value) => value.to_string(),
        Literal::Float(value) => format!("{value:?}"),
        other => panic!(
            "expected a number or a truth value, found {other:?}; say here how it is written in Rust"
        ),
    }
}
