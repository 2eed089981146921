//! Archives (`.mdr`) and encapsulated files (`.mdle`): modules and resources in one file, for reading.
//!
//! Both are a marker followed by a ZIP file (language specification, "MDL archive format" and "MDL
//! encapsulated format"). [`Container::read`] takes bytes and gives a tree of files that is a
//! [`Loader`]; nothing is unpacked before it is asked for, and never more than its directory says.
//!
//! Does not: write containers, compare the MD5 sums of encapsulated files (the CRC of each file is
//! compared), follow dependencies to other archives, read encrypted files or ZIP64.

use crate::graph::ResourceKind;
use crate::loader::{LoadError, LoadedSource, Loader, ModuleIdentity, ResolvedResource};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Bytes at the start of an archive.
const ARCHIVE: [u8; 8] = *b"MDR\0\x00\x01\0\0";
/// Bytes at the start of an encapsulated file; the MD5 sum of its content follows.
const ENCAPSULATED: [u8; 8] = *b"MDLE\x00\x01\0\0";
/// Files in a container.
const FILES: usize = 1 << 14;
/// Bytes of one unpacked file.
const FILE_BYTES: usize = 1 << 28;
/// Bytes of the manifest.
const MANIFEST_BYTES: usize = 1 << 20;

/// Which kind of container it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContainerKind {
    /// `.mdr`: the packages below one package, whose dotted name is the name of the file.
    Archive,
    /// `.mdle`: the module `::main` with its resources.
    Encapsulated,
}

/// Why a container cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ContainerError {
    /// It starts with neither marker.
    #[error("this is neither an MDL archive nor an encapsulated MDL file")]
    Marker,
    /// It ends too early, or a part points out of it.
    #[error("the file is damaged: {0}")]
    Damaged(&'static str),
    /// It uses something of the ZIP format that the language does not allow.
    #[error("`{file}` uses {what}, which containers may not")]
    Forbidden {
        /// The file in it.
        file: String,
        /// What is used.
        what: &'static str,
    },
    /// The name of a file is no path within the container, or is used twice.
    #[error("bad file name `{0}` in the container")]
    Name(String),
    /// It is larger than what is read.
    #[error("too large: more than {limit} {what}")]
    TooLarge {
        /// The limit.
        limit: usize,
        /// Of what.
        what: &'static str,
    },
    /// The manifest of an archive is missing or cannot be read.
    #[error("the manifest is wrong: {0}")]
    Manifest(String),
    /// A file lies outside of the package that the archive is named after.
    #[error("`{file}` is not below the package `{package}` that the archive is named after")]
    OutsidePackage {
        /// The file.
        file: String,
        /// The package, with dots.
        package: String,
    },
}

use ContainerError as Error;

/// Files of an archive or encapsulated file.
#[derive(Clone, Debug)]
pub struct Container {
    /// Which kind it is.
    pub kind: ContainerKind,
    /// Keys and values of the manifest, in their order; empty if there is none.
    pub manifest: Vec<(String, String)>,
    name: Arc<str>,
    bytes: Arc<[u8]>,
    files: BTreeMap<String, Stored>,
}

/// A file within a container.
#[derive(Clone, Copy, Debug)]
struct Stored {
    /// Where its bytes start.
    start: usize,
    packed: usize,
    unpacked: usize,
    deflated: bool,
    crc: u32,
}

impl Container {
    /// Reads the directory of a container. `name` is the name of its file, such as `woods.oak.mdr`.
    pub fn read(name: &str, bytes: impl Into<Arc<[u8]>>) -> Result<Self, Error> {
        let bytes = bytes.into();
        let (kind, zip) = match bytes.get(..8) {
            Some(marker) if marker == ARCHIVE => (ContainerKind::Archive, 8),
            Some(marker) if marker == ENCAPSULATED => (ContainerKind::Encapsulated, 24),
            _ => return Err(Error::Marker),
        };
        let (files, first) = Directory { bytes: &bytes, zip }.read()?;
        let mut container = Self { kind, manifest: Vec::new(), name: name.into(), bytes, files };
        match kind {
            ContainerKind::Archive => container.check_archive(&first)?,
            ContainerKind::Encapsulated if !container.files.contains_key("main.mdl") => {
                return Err(Error::Damaged("an encapsulated file needs a `main.mdl`"));
            }
            ContainerKind::Encapsulated => {}
        }
        Ok(container)
    }

    /// Names of all modules, such as `::woods::oak`.
    pub fn modules(&self) -> impl Iterator<Item = String> {
        let stems = self.files.keys().filter_map(|path| path.strip_suffix(".mdl"));
        stems.map(|stem| stem.split('/').flat_map(|part| ["::", part]).collect())
    }

    /// Paths of all files, with `/` between folders and none before them.
    pub fn files(&self) -> impl Iterator<Item = &str> {
        self.files.keys().map(String::as_str)
    }

    /// The content of a file; `None` if there is no such file.
    pub fn file(&self, path: &str) -> Result<Option<Vec<u8>>, Error> {
        let Some(stored) = self.files.get(path) else { return Ok(None) };
        let packed = &self.bytes[stored.start..stored.start + stored.packed];
        let content = match stored.deflated {
            false => packed.to_vec(),
            true => miniz_oxide::inflate::decompress_to_vec_with_limit(packed, stored.unpacked)
                .map_err(|_| Error::Damaged("a file cannot be unpacked"))?,
        };
        match content.len() == stored.unpacked && crc32(&content) == stored.crc {
            true => Ok(Some(content)),
            false => Err(Error::Damaged("the checksum of a file is wrong")),
        }
    }

    /// Reads the manifest, and checks that all modules lie in the package of the archive.
    fn check_archive(&mut self, first: &str) -> Result<(), Error> {
        let manifest = self.files.get("MANIFEST").copied();
        let Some(manifest) = manifest.filter(|stored| first == "MANIFEST" && !stored.deflated) else {
            return Err(Error::Manifest("it must be the first file, and not be packed".to_string()));
        };
        if manifest.unpacked > MANIFEST_BYTES {
            return Err(Error::TooLarge { limit: MANIFEST_BYTES, what: "bytes of manifest" });
        }
        let text = self.file("MANIFEST")?.unwrap_or_default();
        self.manifest = parse_manifest(&String::from_utf8_lossy(&text))?;
        let file = self.name.rsplit(['/', '\\']).next().unwrap_or_default();
        let package = file.strip_suffix(".mdr").unwrap_or(file).to_string();
        let folder = package.replace('.', "/");
        let belongs = |path: &str| {
            let stem = path.strip_suffix(".mdl").unwrap_or(path);
            stem == folder || stem.strip_prefix(&folder).is_some_and(|rest| rest.starts_with('/'))
        };
        match self.files.keys().find(|path| *path != "MANIFEST" && !belongs(path)) {
            Some(file) => Err(Error::OutsidePackage { file: file.clone(), package }),
            None => Ok(()),
        }
    }
}

/// Lines such as `version = "1.0.0"`; `//` and `#` start comments.
fn parse_manifest(text: &str) -> Result<Vec<(String, String)>, Error> {
    let mut entries = Vec::new();
    for line in text.lines().map(str::trim) {
        if line.is_empty() || line.starts_with("//") || line.starts_with('#') {
            continue;
        }
        let bad = || Error::Manifest(format!("`{}`", line.chars().take(60).collect::<String>()));
        let (key, value) = line.split_once('=').ok_or_else(bad)?;
        let value = value.trim();
        let value = value.strip_prefix('"').and_then(|value| value.strip_suffix('"')).ok_or_else(bad)?;
        entries.push((key.trim().to_string(), value.replace("\\\"", "\"").replace("\\\\", "\\")));
    }
    match entries.iter().any(|(key, _)| key == "mdl") {
        true => Ok(entries),
        false => {
            Err(Error::Manifest("it does not say the version of the language, `mdl = \"1.3\"`".to_string()))
        }
    }
}

impl Loader for Container {
    fn load(&self, module: &[String], _: Option<&ModuleIdentity>) -> Result<Option<LoadedSource>, LoadError> {
        let path = format!("{}.mdl", module.join("/"));
        let content = self.file(&path).map_err(|error| LoadError(error.to_string()))?;
        Ok(content.map(|bytes| LoadedSource {
            identity: ModuleIdentity {
                segments: module.into(),
                file: format!("{}:{path}", self.name).into(),
                root: self.name.clone(),
            },
            bytes,
        }))
    }

    fn resolve_resource(
        &self,
        path: &str,
        _: ResourceKind,
        _: &ModuleIdentity,
    ) -> Result<Option<ResolvedResource>, LoadError> {
        let inside = path.trim_start_matches('/');
        let known = self.files.contains_key(inside);
        let found =
            || ResolvedResource { path: format!("{}:{inside}", self.name).into(), root: self.name.clone() };
        Ok(known.then(found))
    }

    fn siblings(&self, package: &[String]) -> Vec<String> {
        let prefix: String = package.iter().flat_map(|part| [part, "/"]).collect();
        let below = self.files.keys().filter_map(|path| path.strip_prefix(&prefix)?.strip_suffix(".mdl"));
        below.filter(|name| !name.contains('/')).map(str::to_string).collect()
    }
}

/// The directory of a ZIP file (PKWARE, "APPNOTE.TXT", sections 4.3.7, 4.3.12 and 4.3.16).
struct Directory<'b> {
    bytes: &'b [u8],
    /// Where the ZIP file starts.
    zip: usize,
}

impl Directory<'_> {
    /// All files by name, and the name of the first.
    fn read(&self) -> Result<(BTreeMap<String, Stored>, String), Error> {
        const END: usize = 22;
        let last = self.bytes.len().checked_sub(END).ok_or(Error::Damaged("it has no directory"))?;
        let from = last.saturating_sub(0xFFFF).max(self.zip);
        let end = (from..=last).rev().find(|at| self.bytes[*at..].starts_with(b"PK\x05\x06"));
        let end = end.ok_or(Error::Damaged("it has no directory"))?;
        let (count, size, offset) = (self.u16(end + 10)?, self.u32(end + 12)?, self.u32(end + 16)?);
        if count > FILES {
            return Err(Error::TooLarge { limit: FILES, what: "files" });
        }
        // Offsets count from the marker or from behind it; where the directory is tells which.
        let start = end.checked_sub(size).ok_or(Error::Damaged("its directory is too long"))?;
        let base = start.checked_sub(offset).ok_or(Error::Damaged("its directory is too long"))?;
        let (mut files, mut at) = (BTreeMap::new(), start);
        let mut first = (usize::MAX, String::new());
        for _ in 0..count {
            if !self.bytes[at.min(end)..end].starts_with(b"PK\x01\x02") {
                return Err(Error::Damaged("its directory ends early"));
            }
            let lengths = [self.u16(at + 28)?, self.u16(at + 30)?, self.u16(at + 32)?];
            let name = self.slice(at + 46, lengths[0])?;
            let name = String::from_utf8(name.to_vec())
                .map_err(|error| Error::Name(String::from_utf8_lossy(error.as_bytes()).into_owned()))?;
            let header = base + self.u32(at + 42)?;
            if header < first.0 {
                first = (header, name.clone());
            }
            if !name.ends_with('/') {
                let stored = self.stored(&name, at, header)?;
                if !is_path(&name) || files.insert(name.clone(), stored).is_some() {
                    return Err(Error::Name(name));
                }
            }
            at += 46 + lengths.iter().sum::<usize>();
        }
        Ok((files, first.1))
    }

    /// Where a file's bytes are, from its entries in the directory and before itself.
    fn stored(&self, name: &str, entry: usize, header: usize) -> Result<Stored, Error> {
        let forbidden = |what| Error::Forbidden { file: name.to_string(), what };
        if self.u16(entry + 8)? & 1 != 0 {
            return Err(forbidden("encryption"));
        }
        let deflated = match self.u16(entry + 10)? {
            0 => false,
            8 => true,
            _ => return Err(forbidden("another method than deflation")),
        };
        let (packed, unpacked) = (self.u32(entry + 20)?, self.u32(entry + 24)?);
        if packed == 0xFFFF_FFFF || unpacked == 0xFFFF_FFFF {
            return Err(forbidden("ZIP64"));
        }
        if unpacked > FILE_BYTES {
            return Err(Error::TooLarge { limit: FILE_BYTES, what: "bytes in one file" });
        }
        if !deflated && packed != unpacked {
            return Err(Error::Damaged("a file has two lengths"));
        }
        if self.slice(header, 4)? != b"PK\x03\x04" {
            return Err(Error::Damaged("a file is not where the directory says"));
        }
        let start = header + 30 + self.u16(header + 26)? + self.u16(header + 28)?;
        self.slice(start, packed)?;
        Ok(Stored { start, packed, unpacked, deflated, crc: self.u32(entry + 16)? as u32 })
    }

    fn slice(&self, at: usize, length: usize) -> Result<&[u8], Error> {
        let end = at.checked_add(length).ok_or(Error::Damaged("a part is too long"))?;
        self.bytes.get(at..end).ok_or(Error::Damaged("it ends too early"))
    }

    fn u16(&self, at: usize) -> Result<usize, Error> {
        let bytes = self.slice(at, 2)?;
        Ok(usize::from(u16::from_le_bytes([bytes[0], bytes[1]])))
    }

    fn u32(&self, at: usize) -> Result<usize, Error> {
        let bytes = self.slice(at, 4)?;
        Ok(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as usize)
    }
}

/// Whether a name is a path that stays within the container.
fn is_path(name: &str) -> bool {
    let bad = |part: &str| part.is_empty() || part == "." || part == "..";
    let forbidden = |c: char| matches!(c, '\\' | ':') || c.is_control();
    !name.split('/').any(bad) && !name.contains(forbidden)
}

/// The checksum of ZIP files: CRC-32 with the polynomial 0x04C11DB7, reflected.
fn crc32(bytes: &[u8]) -> u32 {
    const TABLE: [u32; 256] = {
        let mut table = [0u32; 256];
        let mut index = 0;
        while index < 256 {
            let (mut value, mut bit) = (index as u32, 0);
            while bit < 8 {
                value = (value >> 1) ^ (0xEDB8_8320 * (value & 1));
                bit += 1;
            }
            table[index] = value;
            index += 1;
        }
        table
    };
    !bytes.iter().fold(!0, |crc, byte| (crc >> 8) ^ TABLE[((crc ^ u32::from(*byte)) & 0xFF) as usize])
}
