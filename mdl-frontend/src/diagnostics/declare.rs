//! The notation for diagnostics.

use crate::span::FileSpan;

/// Declares diagnostics:
///
/// ```text
/// /// Manual page: what it means. Fix: what to do.
/// E0301 Unknown { name: String, first: FileSpan }
///     "unknown name `{name}`"
///     label(first, "first declared here")
///     help("import it");
/// ```
///
/// The message and labels are format strings over the fields. The first label is the place itself, with
/// the text of `here(...)` if there is one. A label's field is a `FileSpan`, an `Option` or a `Vec` of
/// it. `help` takes an expression over the fields: text, or an `Option` of text.
macro_rules! diagnostics {
    ($(
        $(#[doc = $doc:literal])*
        $code:ident $name:ident { $($(#[doc = $field_doc:literal])* $field:ident: $ty:ty),* $(,)? }
            $message:literal
            $(here($here:literal))?
            $(label($label:ident, $text:literal))*
            $(help($help:expr))?;
    )*) => {
        $(
            #[doc = concat!(stringify!($code), " ·")]
            $(#[doc = $doc])*
            #[derive(Clone, Debug)]
            pub struct $name {
                $($(#[doc = $field_doc])* #[allow(missing_docs, reason = "the message says it")] pub $field: $ty,)*
            }

            impl $crate::diagnostics::Problem for $name {
                const CODE: $crate::diagnostics::Code = $crate::diagnostics::Code(stringify!($code));

                fn at(self, place: $crate::span::FileSpan) -> $crate::diagnostics::Diagnostic {
                    let Self { $($field),* } = self;
                    #[allow(unused_mut, unused_assignments, reason = "most have neither")]
                    let mut here = String::new();
                    $(here = format!($here);)?
                    #[allow(unused_mut, reason = "most have no further labels")]
                    let mut labels = vec![(place, here)];
                    $($crate::diagnostics::declare::Labels::each(&$label, |place| {
                        labels.push((place, format!($text)));
                    });)*
                    let message = format!($message);
                    #[allow(unused_mut, unused_assignments, reason = "most have no help")]
                    let mut help = None;
                    $(help = $crate::diagnostics::declare::Help::text($help);)?
                    let code = <Self as $crate::diagnostics::Problem>::CODE;
                    $crate::diagnostics::Diagnostic { code, severity: code.severity(), message, labels, help }
                }
            }
        )*

        /// The diagnostics of this family.
        pub const ALL: &[$crate::diagnostics::Explanation] = &[$(
            $crate::diagnostics::Explanation {
                code: $crate::diagnostics::Code(stringify!($code)),
                text: concat!($($doc, "\n"),*),
            },
        )*];
    };
}

/// Fields that are further places.
pub(super) trait Labels {
    fn each(&self, label: impl FnMut(FileSpan));
}

impl Labels for FileSpan {
    fn each(&self, mut label: impl FnMut(FileSpan)) {
        label(self.clone());
    }
}

impl Labels for Option<FileSpan> {
    fn each(&self, label: impl FnMut(FileSpan)) {
        self.iter().cloned().for_each(label);
    }
}

impl Labels for Vec<FileSpan> {
    fn each(&self, label: impl FnMut(FileSpan)) {
        self.iter().cloned().for_each(label);
    }
}

/// What `help` accepts.
pub(super) trait Help {
    fn text(self) -> Option<String>;
}

impl Help for &str {
    fn text(self) -> Option<String> {
        Some(self.to_string())
    }
}

impl Help for String {
    fn text(self) -> Option<String> {
        Some(self)
    }
}

impl Help for Option<String> {
    fn text(self) -> Option<String> {
        self
    }
}

impl Help for Option<&str> {
    fn text(self) -> Option<String> {
        self.map(str::to_string)
    }
}

/// "did you mean": the help of everything that misspelling may have caused.
pub(super) fn did_you_mean(similar: Option<String>) -> Option<String> {
    similar.map(|name| format!("did you mean `{name}`?"))
}
