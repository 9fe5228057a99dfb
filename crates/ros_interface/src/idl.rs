//! Messages as OMG IDL, for a monitor that uses plain DDS: names, order and types are those on the wire, the comments are
//! those of the definitions.

use std::fmt::Write as _;

use re_ros_msg::message_spec::{ArraySize, BuiltInType, Literal, Type};

use crate::interface::{DefinitionError, Definitions, Interface};

/// The definitions of `interfaces` and of all their dependencies, each once; a definition precedes those that use it.
///
/// # Errors
/// A definition is wrong, or names a type that is not among `definitions`.
pub fn idl(
    interfaces: &[&'static Interface],
    definitions: Definitions<'_>,
) -> Result<String, DefinitionError> {
    let mut ordered = Vec::new();
    for interface in interfaces {
        collect(interface, definitions, &mut ordered)?;
    }
    let mut text = String::new();
    for (index, interface) in ordered.iter().enumerate() {
        if index > 0 {
            text.push('\n');
        }
        text += &definition(interface, definitions)?;
    }
    Ok(text)
}

fn collect(
    interface: &'static Interface,
    definitions: Definitions<'_>,
    ordered: &mut Vec<&'static Interface>,
) -> Result<(), DefinitionError> {
    if ordered.contains(&interface) {
        return Ok(());
    }
    for used in interface.field_types(definitions)? {
        collect(used, definitions, ordered)?;
    }
    ordered.push(interface);
    Ok(())
}

fn definition(
    interface: &Interface,
    definitions: Definitions<'_>,
) -> Result<String, DefinitionError> {
    let specification = interface.specification()?;
    let name = interface.type_name();
    let comments = Comments::of(interface.text());
    let mut text = comments.block(&comments.head, 0);
    let _ = writeln!(text, "module {} {{ module msg {{", interface.package());
    if !specification.constants.is_empty() {
        let _ = writeln!(text, "module {name}_Constants {{");
        for constant in &specification.constants {
            text += &comments.above(&constant.name, 2);
            let ty = type_name(interface, &constant.ty, definitions)?;
            let value = literal(&constant.value);
            let _ = writeln!(text, "  const {ty} {} = {value};", constant.name);
        }
        text += "};\n";
    }
    let _ = writeln!(text, "module dds_ {{\n@final\nstruct {name}_ {{");
    for field in &specification.fields {
        text += &comments.above(&field.name, 2);
        let (element, length) = match &field.ty {
            Type::Array {
                ty,
                size: ArraySize::Fixed(length),
            } => (&**ty, format!("[{length}]")),
            other => (other, String::new()),
        };
        let ty = type_name(interface, element, definitions)?;
        let _ = writeln!(text, "  {ty} {}{length};", field.name);
    }
    text += "};\n}; }; };\n";
    Ok(text)
}

fn type_name(
    interface: &Interface,
    ty: &Type,
    definitions: Definitions<'_>,
) -> Result<String, DefinitionError> {
    Ok(match ty {
        Type::BuiltIn(built_in) => built_in_name(built_in),
        Type::Complex(nested) => interface.resolve(nested, definitions)?.dds_name(),
        Type::Array { ty, size } => {
            let element = type_name(interface, ty, definitions)?;
            match size {
                ArraySize::Bounded(length) | ArraySize::Fixed(length) => {
                    format!("sequence<{element}, {length}>")
                }
                ArraySize::Unbounded => format!("sequence<{element}>"),
            }
        }
    })
}

/// The names of the classic IDL types, which every vendor's compiler knows.
fn built_in_name(built_in: &BuiltInType) -> String {
    let bounded = |name: &str, length: &Option<usize>| match length {
        Some(length) => format!("{name}<{length}>"),
        None => name.to_owned(),
    };
    match built_in {
        BuiltInType::Bool => "boolean",
        // IDL's int8 is younger than most compilers; the byte on the wire is the same.
        BuiltInType::Byte | BuiltInType::Char | BuiltInType::UInt8 | BuiltInType::Int8 => "octet",
        BuiltInType::Int16 => "short",
        BuiltInType::UInt16 => "unsigned short",
        BuiltInType::Int32 => "long",
        BuiltInType::UInt32 => "unsigned long",
        BuiltInType::Int64 => "long long",
        BuiltInType::UInt64 => "unsigned long long",
        BuiltInType::Float32 => "float",
        BuiltInType::Float64 => "double",
        BuiltInType::String(length) => return bounded("string", length),
        BuiltInType::WString(length) => return bounded("wstring", length),
    }
    .to_owned()
}

fn literal(value: &Literal) -> String {
    match value {
        Literal::Bool(value) => if *value { "TRUE" } else { "FALSE" }.to_owned(),
        Literal::Int(value) => value.to_string(),
        Literal::UInt(value) => value.to_string(),
        Literal::Float(value) => format!("{value:?}"),
        Literal::String(value) => format!("{value:?}"),
        Literal::Array(values) => {
            let values: Vec<_> = values.iter().map(literal).collect();
            format!("{{{}}}", values.join(", "))
        }
    }
}

/// The comments of a definition. A comment belongs to the entry below it, or to the entry on the same line.
struct Comments {
    head: Vec<String>,
    above: Vec<(String, Vec<String>)>,
}

impl Comments {
    fn of(text: &str) -> Self {
        let mut comments = Self {
            head: Vec::new(),
            above: Vec::new(),
        };
        let mut pending = Vec::new();
        for line in text.lines().map(str::trim) {
            if let Some(comment) = line.strip_prefix('#') {
                pending.push(comment.trim().to_owned());
            } else if line.is_empty() {
                // A comment followed by an empty line describes the whole definition.
                comments.head.append(&mut pending);
            } else {
                let (entry, comment) = line.split_once('#').unwrap_or((line, ""));
                if !comment.is_empty() {
                    pending.push(comment.trim().to_owned());
                }
                let name = entry.split_whitespace().nth(1).unwrap_or_default();
                let name = name.split('=').next().unwrap_or_default().to_owned();
                comments.above.push((name, std::mem::take(&mut pending)));
            }
        }
        comments
    }

    fn above(&self, name: &str, indent: usize) -> String {
        let found = self.above.iter().find(|(entry, _)| entry == name);
        found.map_or_else(String::new, |(_, lines)| self.block(lines, indent))
    }

    fn block(&self, lines: &[String], indent: usize) -> String {
        let lines = lines.iter().filter(|line| !line.is_empty());
        lines.fold(String::new(), |text, line| {
            text + &format!("{:indent$}// {line}\n", "")
        })
    }
}
