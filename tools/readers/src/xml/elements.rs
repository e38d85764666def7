//! Elements from a reader, one after the other, each with all that is in it.

use std::io::BufRead;
use std::ops::Range;
use std::sync::Arc;

use quick_xml::events::{BytesStart, Event};
use quick_xml::name::{NamespaceResolver, ResolveResult};
use quick_xml::{NsReader, XmlVersion};

use super::{Attribute, Element, XmlProblem};

/// No format that is read here nests anywhere near as deep.
const DEEPEST: usize = 200;

/// The root of `elements`; errors with the byte they are about.
pub(super) fn tree(mut elements: Elements<'_>) -> Result<Element, (usize, XmlProblem)> {
    let malformed = |at, reason: &str| Err((at, XmlProblem::Malformed(reason.to_owned())));
    let Some(root) = elements.next()? else { return malformed(0, "there is no element") };
    match elements.next()? {
        None => Ok(root),
        Some(_) => malformed(elements.part.end, "there is more than one root element"),
    }
}

/// Elements that stand one after the other in a part of a file.
pub(super) struct Elements<'t> {
    reader: NsReader<Box<dyn BufRead + 't>>,
    /// Where the part lies in the file.
    part: Range<usize>,
    namespaces: Namespaces,
    /// The items of what is called so are left where they are.
    left: Option<&'static str>,
}

impl<'t> Elements<'t> {
    /// Of the `part` of a file that `reader` reads; without the items of lists called `left`, but with where those are.
    pub fn new(reader: Box<dyn BufRead + 't>, part: Range<usize>, left: Option<&'static str>) -> Self {
        Self { reader: NsReader::from_reader(reader), part, namespaces: Namespaces::default(), left }
    }

    /// What the reader objects to, and where.
    fn malformed(&self, error: &quick_xml::Error) -> (usize, XmlProblem) {
        (self.at(self.reader.error_position()), XmlProblem::Malformed(error.to_string()))
    }

    /// Where in the file the reader's `offset` is.
    fn at(&self, offset: u64) -> usize {
        self.part.start.saturating_add(usize::try_from(offset).unwrap_or(usize::MAX)).min(self.part.end)
    }

    /// The next with all that is in it.
    pub fn next(&mut self) -> Result<Option<Element>, (usize, XmlProblem)> {
        // Elements that have begun and not ended.
        let mut open: Vec<Element> = Vec::new();
        let (mut buffer, mut skipped) = (Vec::new(), Vec::new());
        loop {
            buffer.clear();
            let start = self.at(self.reader.buffer_position());
            let malformed = |reason: String| (start, XmlProblem::Malformed(reason));
            let read = self.reader.read_event_into(&mut buffer).map_err(|error| self.malformed(&error))?;
            let end = self.at(self.reader.buffer_position());
            let empty = matches!(read, Event::Empty(_));
            let ended = match read {
                Event::Start(tag) | Event::Empty(tag) => {
                    let element = element(&tag, self.reader.resolver(), &mut self.namespaces, start..end);
                    let mut element = element.map_err(malformed)?;
                    let left = !empty && self.left.is_some_and(|left| left == element.name);
                    if left {
                        let span = self.reader.read_to_end_into(tag.name(), &mut skipped);
                        let span = span.map_err(|error| self.malformed(&error))?;
                        element.left = self.at(span.start)..self.at(span.end);
                    }
                    if !empty && !left {
                        open.push(element);
                        if open.len() > DEEPEST {
                            return Err((start, XmlProblem::TooDeep(DEEPEST)));
                        }
                        continue;
                    }
                    Some(element)
                }
                // The reader has checked that it closes what is open.
                Event::End(_) => open.pop(),
                Event::Eof => {
                    return match open.pop() {
                        None => Ok(None),
                        Some(unclosed) => {
                            let reason = format!("`{}` is not closed", unclosed.name);
                            Err((unclosed.span.start, XmlProblem::Malformed(reason)))
                        }
                    };
                }
                _ => continue,
            };
            match (ended, open.last_mut()) {
                (Some(element), Some(parent)) => parent.children.push(element),
                (Some(element), None) => return Ok(Some(element)),
                (None, _) => return Err(malformed("an element ends that did not begin".to_owned())),
            }
        }
    }
}

/// Namespaces of a file, each kept once.
#[derive(Default)]
struct Namespaces(Vec<Arc<str>>);

impl Namespaces {
    fn shared(&mut self, found: ResolveResult<'_>) -> Option<Arc<str>> {
        let ResolveResult::Bound(namespace) = found else { return None };
        let uri = namespace.as_ref();
        if let Some(known) = self.0.iter().find(|known| &***known == uri) {
            return Some(Arc::clone(known));
        }
        let new: Arc<str> = Arc::from(uri);
        self.0.push(Arc::clone(&new));
        Some(new)
    }
}

fn element(
    tag: &BytesStart<'_>,
    resolver: &NamespaceResolver,
    namespaces: &mut Namespaces,
    span: Range<usize>,
) -> Result<Element, String> {
    let mut attributes = Vec::new();
    for attribute in tag.attributes() {
        let attribute = attribute.map_err(|error| error.to_string())?;
        let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|error| error.to_string())?;
        // A declaration of a namespace is no attribute.
        if attribute.key.as_namespace_binding().is_none() {
            let (resolved, name) = resolver.resolve_attribute(attribute.key);
            let prefix = attribute.key.prefix().map(|prefix| Arc::from(prefix.as_ref()));
            let (name, value) = (name.as_ref().to_owned(), value.into_owned());
            let namespace = namespaces.shared(resolved).or(prefix);
            attributes.push(Attribute { name, value, namespace });
        }
    }
    let namespace = namespaces.shared(resolver.resolve_element(tag.name()).0);
    let name = tag.local_name().as_ref().to_owned();
    Ok(Element { name, namespace, attributes, children: Vec::new(), span, left: 0..0 })
}
