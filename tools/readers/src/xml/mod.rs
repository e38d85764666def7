//! XML files as trees whose elements know their place, for errors that point at the line. `elements` reads them.

mod elements;

use std::fmt;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::{Arc, OnceLock};

use encoding_rs::UTF_8;
use thiserror::Error;

use elements::{Elements, tree};

use crate::error::{InputError, Problem};
use crate::source::{HEAD, Source, encoding};

/// What can be wrong with an XML file.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum XmlProblem {
    /// Not XML.
    #[error("not well-formed XML: {0}")]
    Malformed(String),
    /// Elements in elements without end.
    #[error("elements are nested more than {0} deep")]
    TooDeep(usize),
    /// Another kind of file.
    #[error("the root element is `{found}`, not `{expected}`")]
    Root {
        /// What it should be.
        expected: &'static str,
        /// What it is.
        found: String,
    },
    /// An attribute that must be there.
    #[error("`{element}` has no attribute `{attribute}`")]
    MissingAttribute {
        /// The element.
        element: String,
        /// The attribute.
        attribute: &'static str,
    },
    /// An element that must be there.
    #[error("`{element}` has no element `{child}`")]
    MissingElement {
        /// The element.
        element: String,
        /// What it lacks.
        child: &'static str,
    },
    /// A value of another type.
    #[error("`{attribute}=\"{text}\"` of `{element}` is not {expected}")]
    Value {
        /// The element.
        element: String,
        /// The attribute.
        attribute: String,
        /// Its value.
        text: String,
        /// What it should be.
        expected: &'static str,
    },
}

/// A parsed file.
#[derive(Debug)]
pub struct XmlFile {
    source: Origin,
    root: Element,
}

/// Where the text of a file is.
#[derive(Debug)]
enum Origin {
    /// In memory.
    Text(Source),
    /// On the disk, at `path`, called otherwise in messages, for which alone it is read as a whole.
    Disk { path: PathBuf, called: PathBuf, whole: OnceLock<Option<Source>> },
}

impl Origin {
    fn error(&self, span: Range<usize>, problem: Problem) -> InputError {
        match self {
            Self::Text(source) => source.error(span, problem),
            Self::Disk { path, called, .. } => {
                // What is no text at all is the cause of every other problem.
                let read = io_read(path, called).and_then(|bytes| Source::from_xml_bytes(called, bytes));
                read.map_or_else(|error| error, |source| source.error(span, problem))
            }
        }
    }

    fn place(&self, at: usize) -> String {
        let (source, called) = match self {
            Self::Text(source) => (Some(source), source.path()),
            Self::Disk { path, called, whole } => {
                let read =
                    || io_read(path, called).and_then(|bytes| Source::from_xml_bytes(called, bytes)).ok();
                (whole.get_or_init(read).as_ref(), called.as_path())
            }
        };
        let name = called.file_name().unwrap_or_default().to_string_lossy().into_owned();
        source.map_or(name.clone(), |source| format!("{name}:{}", source.line(at)))
    }
}

/// The bytes of the file at `path`, which errors call `called`.
fn io_read(path: &Path, called: &Path) -> Result<Vec<u8>, InputError> {
    std::fs::read(path).map_err(|error| unreadable(called, &error))
}

fn unreadable(called: &Path, error: &io::Error) -> InputError {
    InputError { path: called.to_owned(), excerpt: None, problem: Box::new(unread(error)) }
}

fn unread(error: &io::Error) -> Problem {
    Problem::Unreadable { what: "the file".to_owned(), reason: error.to_string() }
}

/// An element: names without their namespace prefixes.
#[derive(Debug, Clone, PartialEq)]
pub struct Element {
    name: String,
    namespace: Option<Arc<str>>,
    attributes: Vec<Attribute>,
    children: Vec<Element>,
    span: Range<usize>,
    /// Where its items are, if they were left in the text.
    left: Range<usize>,
}

/// An attribute of an element.
#[derive(Debug, Clone, PartialEq)]
struct Attribute {
    name: String,
    value: String,
    /// The namespace that its prefix stands for, or the prefix where it stands for none; absent without a prefix.
    namespace: Option<Arc<str>>,
}

impl XmlFile {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// A file that cannot be read, is not in the encoding that it declares, or not well-formed.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::parse(Source::read_xml(path)?, None)
    }

    /// Parses `bytes`, which errors call `path`.
    ///
    /// # Errors
    /// As [`XmlFile::read`].
    pub fn from_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, InputError> {
        Self::parse(Source::from_xml_bytes(path, bytes)?, None)
    }

    /// As [`XmlFile::read`], but what is in lists called `list` is left in the file, since it may be a million items:
    /// [`XmlFile::items`] reads them one by one. Errors call the file `called`.
    ///
    /// # Errors
    /// As [`XmlFile::read`], of what is not in such lists.
    pub fn read_but(list: &'static str, path: &Path, called: &Path) -> Result<Self, InputError> {
        let mut file = File::open(path).map_err(|error| unreadable(called, &error))?;
        let mut head = Vec::new();
        let begin = (&mut file).take(HEAD as u64).read_to_end(&mut head);
        begin.map_err(|error| unreadable(called, &error))?;
        // Only what is plain UTF-8 is not decoded as a whole.
        if head.starts_with(&[0xef, 0xbb, 0xbf]) || encoding(&head) != Ok(UTF_8) {
            return Self::parse(Source::from_xml_bytes(called, io_read(path, called)?)?, Some(list));
        }
        let source =
            Origin::Disk { path: path.to_owned(), called: called.to_owned(), whole: OnceLock::new() };
        let length = file.seek(SeekFrom::End(0)).and_then(|length| file.rewind().map(|()| length));
        let length = length.map_err(|error| unreadable(called, &error))?;
        let part = 0..usize::try_from(length).unwrap_or(usize::MAX);
        let root = tree(Elements::new(Box::new(BufReader::new(file)), part, Some(list)));
        match root {
            Ok(root) => Ok(Self { source, root }),
            Err((at, problem)) => Err(source.error(at..at + 1, problem.into())),
        }
    }

    /// The items of `list` that were left. Their namespaces are those that they declare themselves.
    pub fn items(&self, list: &Element) -> Items<'_> {
        let part = list.left.clone();
        let reader: io::Result<Box<dyn BufRead + '_>> = match &self.source {
            Origin::Text(source) => {
                Ok(Box::new(source.text().get(part.clone()).unwrap_or_default().as_bytes()))
            }
            Origin::Disk { path, .. } => File::open(path).and_then(|mut file| {
                file.seek(SeekFrom::Start(part.start as u64))?;
                Ok(Box::new(BufReader::new(file.take(part.len() as u64))) as Box<dyn BufRead>)
            }),
        };
        Items { file: self, elements: reader.map(|reader| Elements::new(reader, part, None)).map_err(Some) }
    }

    fn parse(source: Source, left: Option<&'static str>) -> Result<Self, InputError> {
        let elements = Elements::new(Box::new(source.text().as_bytes()), 0..source.text().len(), left);
        let root = tree(elements).map_err(|(at, problem)| source.error(at..at + 1, problem.into()))?;
        Ok(Self { source: Origin::Text(source), root })
    }

    /// The root element, which must be called `name`.
    ///
    /// # Errors
    /// [`XmlProblem::Root`].
    pub fn root(&self, name: &'static str) -> Result<&Element, InputError> {
        if self.root.name == name {
            return Ok(&self.root);
        }
        let problem = XmlProblem::Root { expected: name, found: self.root.name.clone() };
        Err(self.error(&self.root, problem))
    }

    /// An error about an element.
    pub fn error(&self, element: &Element, problem: impl Into<Problem>) -> InputError {
        self.source.error(element.span.clone(), problem.into())
    }

    /// `file:line` of an element, for remarks.
    pub fn place(&self, element: &Element) -> String {
        self.source.place(element.span.start)
    }

    /// The attribute `name` of `element`, which must be there.
    ///
    /// # Errors
    /// [`XmlProblem::MissingAttribute`].
    pub fn required<'e>(&self, element: &'e Element, name: &'static str) -> Result<&'e str, InputError> {
        element.attribute(name).ok_or_else(|| {
            self.error(
                element,
                XmlProblem::MissingAttribute { element: element.name.clone(), attribute: name },
            )
        })
    }

    /// The child `name` of `element`, which must be there.
    ///
    /// # Errors
    /// [`XmlProblem::MissingElement`].
    pub fn required_child<'e>(
        &self,
        element: &'e Element,
        name: &'static str,
    ) -> Result<&'e Element, InputError> {
        element.child(name).ok_or_else(|| {
            self.error(element, XmlProblem::MissingElement { element: element.name.clone(), child: name })
        })
    }

    /// The attribute `name` as a number, if it is there.
    ///
    /// # Errors
    /// [`XmlProblem::Value`].
    pub fn number<T: Numeric>(&self, element: &Element, name: &str) -> Result<Option<T>, InputError> {
        let Some(text) = element.attribute(name) else { return Ok(None) };
        T::from_xml(text).map(Some).ok_or_else(|| self.value_error(element, name, T::EXPECTED))
    }

    /// The attribute `name` as true or false, if it is there.
    ///
    /// # Errors
    /// [`XmlProblem::Value`].
    pub fn boolean(&self, element: &Element, name: &str) -> Result<Option<bool>, InputError> {
        let Some(text) = element.attribute(name) else { return Ok(None) };
        truth(text).map(Some).ok_or_else(|| self.value_error(element, name, "true or false"))
    }

    /// An error about the value of an attribute.
    pub fn value_error(&self, element: &Element, attribute: &str, expected: &'static str) -> InputError {
        let problem = XmlProblem::Value {
            element: element.name.clone(),
            attribute: attribute.to_owned(),
            text: element.attribute(attribute).unwrap_or_default().to_owned(),
            expected,
        };
        self.error(element, problem)
    }
}

/// `xs:boolean`.
pub(crate) fn truth(text: &str) -> Option<bool> {
    match text.trim() {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}

/// Numbers as XML Schema writes them.
pub trait Numeric: Sized {
    /// What was expected, for messages.
    const EXPECTED: &'static str;

    /// The number, if the text is one.
    fn from_xml(text: &str) -> Option<Self>;
}

impl Numeric for f64 {
    const EXPECTED: &'static str = "a finite number";

    fn from_xml(text: &str) -> Option<Self> {
        f64::from_str(text.trim()).ok().filter(|value| value.is_finite())
    }
}

impl Numeric for i32 {
    const EXPECTED: &'static str = "a whole number";

    fn from_xml(text: &str) -> Option<Self> {
        text.trim().parse().ok()
    }
}

impl Numeric for u32 {
    const EXPECTED: &'static str = "a whole number, not negative";

    fn from_xml(text: &str) -> Option<Self> {
        text.trim().parse().ok()
    }
}

impl Element {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The URI of its namespace, if it has one.
    pub fn namespace(&self) -> Option<&str> {
        self.namespace.as_deref()
    }

    /// The value of an attribute without a prefix.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        let mut own = self.attributes.iter().filter(|own| own.namespace.is_none());
        own.find(|own| own.name == name).map(|own| own.value.as_str())
    }

    /// Names of its attributes, with the namespace of those that have a prefix.
    pub fn attributes(&self) -> impl Iterator<Item = (&str, Option<&str>)> {
        self.attributes.iter().map(|own| (own.name.as_str(), own.namespace.as_deref()))
    }

    /// Its elements.
    pub fn children(&self) -> &[Element] {
        &self.children
    }

    /// The first child of a name.
    pub fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|child| child.name == name)
    }

    /// All children of a name.
    pub fn all<'e>(&'e self, name: &'e str) -> impl Iterator<Item = &'e Element> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// The children named `item` of the child named `list`.
    pub fn list<'e>(&'e self, list: &'e str, item: &'e str) -> impl Iterator<Item = &'e Element> {
        self.all(list).flat_map(move |list| list.all(item))
    }
}

impl fmt::Display for Element {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "<{}>", self.name)
    }
}

/// The items of a list that [`XmlFile::read_but`] left in the file, one by one.
pub struct Items<'f> {
    file: &'f XmlFile,
    /// Or why the file cannot be read any more, until it is told.
    elements: Result<Elements<'f>, Option<io::Error>>,
}

impl Iterator for Items<'_> {
    type Item = Result<Element, InputError>;

    fn next(&mut self) -> Option<Self::Item> {
        let source = &self.file.source;
        match &mut self.elements {
            Ok(elements) => {
                elements.next().map_err(|(at, problem)| source.error(at..at + 1, problem.into())).transpose()
            }
            Err(error) => error.take().map(|error| Err(source.error(0..0, unread(&error)))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<XmlFile, InputError> {
        XmlFile::from_bytes(Path::new("a.xml"), text.into())
    }

    #[test]
    fn elements_know_their_line() {
        let file =
            parse("<?xml version=\"1.0\"?>\n<x:a xmlns:x='y'>\n  <b c='1 &lt; 2'/>\n</x:a>\n").unwrap();
        let root = file.root("a").unwrap();
        let child = root.child("b").unwrap();
        assert_eq!(child.attribute("c"), Some("1 < 2"));
        assert_eq!(file.place(child), "a.xml:3");
        assert_eq!(file.required(child, "d").unwrap_err().line(), Some(3));
        assert_eq!(file.root("b").unwrap_err().line(), Some(2));
    }

    #[test]
    fn items_left_in_the_text_are_those_of_the_tree() {
        let text = "<m>\n<list n='1'>\n<a b='2'><c/></a><!-- a remark -->\n<d/></list>\n<e/><list/></m>";
        let whole = parse(text).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("unpacked");
        let read_but = |text: &str| {
            std::fs::write(&path, text).unwrap();
            XmlFile::read_but("list", &path, Path::new("a.xml"))
        };
        for mark in ["", "\u{feff}"] {
            let marked = read_but(&format!("{mark}{text}")).unwrap();
            assert_eq!(marked.items(marked.root("m").unwrap().child("list").unwrap()).count(), 2);
        }
        let left = read_but(text).unwrap();
        let (tree, but) = (whole.root("m").unwrap(), left.root("m").unwrap());
        let items: Vec<Element> =
            but.all("list").flat_map(|list| left.items(list)).collect::<Result<_, _>>().unwrap();
        let known: Vec<Element> = tree.all("list").flat_map(|list| list.children().to_vec()).collect();
        assert_eq!(items, known);
        assert_eq!((left.place(&items[1]).as_str(), but.all("list").count()), ("a.xml:4", 2));
        assert!(but.all("list").all(|list| list.children().is_empty()) && but.child("e").is_some());
        let broken = read_but("<m>\n<list><a b=/></list></m>").unwrap();
        let list = broken.root("m").unwrap().child("list").unwrap();
        let error = broken.items(list).next().unwrap().unwrap_err();
        assert_eq!((error.line(), error.path.to_str()), (Some(2), Some("a.xml")));
        std::fs::write(&path, b"<m>\xff</m>").unwrap();
        let error = XmlFile::read_but("list", &path, Path::new("a.xml")).unwrap_err();
        assert!(error.to_string().contains("UTF-8"), "{error}");
        assert!(XmlFile::read_but("list", &folder.path().join("none"), Path::new("a.xml")).is_err());
    }

    #[test]
    fn what_is_no_xml_is_refused_without_a_panic() {
        for text in
            ["", "   ", "<a>", "<a></b>", "<a/><b/>", "<a b=>", "<a b='&nix;'/>", "plain", "</a>", "<a"]
        {
            assert!(parse(text).is_err(), "{text:?}");
        }
        let deep = "<a>".repeat(100_000);
        let error = parse(&deep).unwrap_err();
        assert!(error.to_string().contains("deep"), "{error}");
    }
}
