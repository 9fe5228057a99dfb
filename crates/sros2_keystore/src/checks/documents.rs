//! The signed documents of an enclave: their signature, and the XML elements that both share.

use openssl::error::ErrorStack;
use openssl::pkcs7::{Pkcs7, Pkcs7Flags};
use openssl::stack::Stack;
use openssl::x509::X509Ref;
use openssl::x509::store::X509StoreBuilder;
use roxmltree::{Document, Node};

use crate::domain_ranges::{DomainRanges, MAX_DOMAIN_ID};

use super::certificates::{Certificate, reason};
use super::fault::{EnclaveFault, EnclaveFile};

/// The text of a document that the permissions authority has signed.
pub(super) fn signed_text(
    file: EnclaveFile,
    smime: &[u8],
    authority: &Certificate,
) -> Result<String, EnclaveFault> {
    let content = verified(smime, &authority.x509).map_err(|error| EnclaveFault::Signature {
        file,
        authority: authority.subject.clone(),
        reason: reason(&error),
    })?;
    String::from_utf8(content).map_err(|_| EnclaveFault::Document {
        file,
        reason: "it is not UTF-8 text".to_owned(),
    })
}

/// The content of an S/MIME message that is signed with the key of this certificate.
fn verified(smime: &[u8], authority: &X509Ref) -> Result<Vec<u8>, ErrorStack> {
    let (signature, content) = Pkcs7::from_smime(smime)?;
    let mut signers = Stack::new()?;
    signers.push(authority.to_owned())?;
    let store = X509StoreBuilder::new()?.build();
    let mut text = Vec::new();
    // The only possible signer is the authority itself, which is trusted as it is: the certificates that the document brings
    // along do not count, and there is no chain. Its dates are checked on their own.
    let flags = Pkcs7Flags::NOINTERN | Pkcs7Flags::NOVERIFY;
    signature.verify(&signers, &store, content.as_deref(), Some(&mut text), flags)?;
    Ok(text)
}

/// Reads a document; `openssl smime -sign -text` puts a header before it.
pub(super) fn parse(file: EnclaveFile, text: &str) -> Result<Document<'_>, EnclaveFault> {
    let xml = text.trim_start();
    let xml = xml.strip_prefix("Content-Type: text/plain").unwrap_or(xml);
    Document::parse(xml.trim_start()).map_err(|error| EnclaveFault::Document {
        file,
        reason: format!("it is not XML: {error}"),
    })
}

/// The child element with this name.
pub(super) fn child<'a, 'input>(
    node: Node<'a, 'input>,
    name: &'static str,
) -> Result<Node<'a, 'input>, String> {
    children(node, name)
        .next()
        .ok_or_else(|| format!("<{}> has no <{name}>", node.tag_name().name()))
}

/// The child elements with this name.
pub(super) fn children<'a, 'input: 'a>(
    node: Node<'a, 'input>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(move |it| it.has_tag_name(name))
}

/// The text of the child element with this name.
pub(super) fn text_of<'a>(node: Node<'a, '_>, name: &'static str) -> Result<&'a str, String> {
    Ok(child(node, name)?.text().unwrap_or_default().trim())
}

/// The domains of an element with `<domains>`.
pub(crate) fn domains_of(node: Node<'_, '_>) -> Result<DomainRanges, String> {
    let number = |text: &str| {
        let number = text.parse::<u16>();
        number.map_err(|_| format!("expected the number of a domain, found `{text}`"))
    };
    let of_member = |member: Node<'_, '_>| match member.tag_name().name() {
        "id" => {
            let id = number(member.text().unwrap_or_default().trim())?;
            Ok(id..=id)
        }
        "id_range" => {
            let bound = |name| text_of(member, name).ok().map(number).transpose();
            Ok(bound("min")?.unwrap_or(0)..=bound("max")?.unwrap_or(MAX_DOMAIN_ID))
        }
        other => Err(format!("<domains> contains the unknown element <{other}>")),
    };
    let members = child(node, "domains")?.children().filter(Node::is_element);
    members.map(of_member).collect()
}
