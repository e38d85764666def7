//! From `fmuResourceLocation` to a path.

use std::path::PathBuf;

/// The directory that a file URI names: `file:///a%20b`, `file:/a`, `file://localhost/a`, and on
/// Windows `file:///C:/a`. A plain path, which some importers pass, is taken as it is.
///
/// # Errors
/// Another scheme, another host, an incomplete `%` escape, or no directory at all: the importer's
/// working directory is not meant.
pub fn directory(uri: &[u8]) -> Result<PathBuf, String> {
    let shown = || String::from_utf8_lossy(uri).into_owned();
    let Some(rest) = strip_scheme(uri) else {
        let colon = uri.iter().position(|byte| *byte == b':');
        // One letter before the colon is a Windows drive.
        if colon.is_some_and(|at| at > 1 && uri[..at].iter().all(u8::is_ascii_alphanumeric)) {
            return Err(format!("fmuResourceLocation {:?} is not a file URI", shown()));
        }
        return path(uri.to_vec());
    };
    let rest = match rest.strip_prefix(b"//") {
        Some(authority) => {
            let end = authority.iter().position(|byte| *byte == b'/').unwrap_or(authority.len());
            let (host, rest) = authority.split_at(end);
            if !(host.is_empty() || host.eq_ignore_ascii_case(b"localhost")) {
                return Err(format!("fmuResourceLocation {:?} is on another host", shown()));
            }
            rest
        }
        None => rest,
    };
    let mut decoded = decode(rest).ok_or_else(|| format!("fmuResourceLocation {:?}: bad escape", shown()))?;
    if let [b'/', drive, b':', ..] = decoded[..]
        && drive.is_ascii_alphabetic()
        && cfg!(windows)
    {
        decoded.remove(0);
    }
    path(decoded)
}

fn strip_scheme(uri: &[u8]) -> Option<&[u8]> {
    let (scheme, rest) = uri.split_at_checked(5)?;
    scheme.eq_ignore_ascii_case(b"file:").then_some(rest)
}

fn decode(text: &[u8]) -> Option<Vec<u8>> {
    let mut decoded = Vec::with_capacity(text.len());
    let mut bytes = text.iter();
    while let Some(byte) = bytes.next() {
        if *byte == b'%' {
            let high = char::from(*bytes.next()?).to_digit(16)?;
            let low = char::from(*bytes.next()?).to_digit(16)?;
            decoded.push((16 * high + low) as u8);
        } else {
            decoded.push(*byte);
        }
    }
    Some(decoded)
}

fn path(bytes: Vec<u8>) -> Result<PathBuf, String> {
    if bytes.is_empty() { Err("fmuResourceLocation names no directory".to_owned()) } else { native(bytes) }
}

#[cfg(unix)]
fn native(bytes: Vec<u8>) -> Result<PathBuf, String> {
    use std::os::unix::ffi::OsStringExt;
    Ok(std::ffi::OsString::from_vec(bytes).into())
}

#[cfg(not(unix))]
fn native(bytes: Vec<u8>) -> Result<PathBuf, String> {
    String::from_utf8(bytes).map(PathBuf::from).map_err(|_| "fmuResourceLocation is not UTF-8".to_owned())
}

#[cfg(test)]
mod tests {
    use super::directory;
    use std::path::Path;

    #[test]
    fn every_spelling_of_a_file_uri_names_the_same_directory() {
        for uri in [
            "file:///tmp/a%20b/resources",
            "file:/tmp/a%20b/resources",
            "FILE:///tmp/a%20b/resources",
            "file://localhost/tmp/a%20b/resources",
            "file:///tmp/a b/resources",
            "/tmp/a b/resources",
        ] {
            assert_eq!(directory(uri.as_bytes()).as_deref(), Ok(Path::new("/tmp/a b/resources")), "{uri}");
        }
        assert_eq!(directory("file:///t%C3%BCr".as_bytes()).as_deref(), Ok(Path::new("/tür")));
    }

    #[test]
    fn other_schemes_hosts_broken_escapes_and_nothing_are_refused() {
        for uri in ["http://x/y", "file://elsewhere/y", "file:///a%2", "file:///a%zz", "", "file:", "file://"]
        {
            assert!(directory(uri.as_bytes()).is_err(), "{uri}");
        }
    }
}
