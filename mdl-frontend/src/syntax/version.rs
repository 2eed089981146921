//! Versions of the language.

use std::fmt;

/// A version of the language, such as 1.10 (minor ten, not one).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Version {
    /// Before the point.
    pub major: u16,
    /// Behind the point.
    pub minor: u16,
}

impl Version {
    /// The newest version that is specified; the standard modules are written in it.
    pub const LATEST: Version = Version::new(1, 10);
    /// The newest version that is accepted: generators write it, with nothing that 1.10 lacks.
    pub const NEWEST_ACCEPTED: Version = Version::new(1, 11);

    /// `major.minor`
    pub const fn new(major: u16, minor: u16) -> Self {
        Self { major, minor }
    }

    /// Reads `1.10`; `None` unless the text is two numbers with a point between.
    pub fn parse(text: &str) -> Option<Self> {
        let (major, minor) = text.split_once('.')?;
        let number = |text: &str| match text.bytes().all(|b| b.is_ascii_digit()) {
            true => text.parse().ok(),
            false => None,
        };
        Some(Self { major: number(major)?, minor: number(minor)? })
    }

    /// Whether modules of this version can be compiled.
    pub fn is_supported(self) -> bool {
        self.major == 1 && self <= Self::NEWEST_ACCEPTED
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minor_version_is_a_number_not_a_fraction() {
        assert_eq!(Version::parse("1.10"), Some(Version::new(1, 10)));
        assert!(Version::parse("1.10") > Version::parse("1.9"));
        assert_eq!(Version::parse("1."), None);
        assert_eq!(Version::parse("1.2e3"), None);
    }
}
