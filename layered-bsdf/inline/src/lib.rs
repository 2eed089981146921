//! `#[wgsl_inline::always]`: what `#[inline(always)]` is, for functions that `wgsl-rs` also prints as WGSL.
//! That macro refuses attributes of one word that it does not know, and passes paths on.

use proc_macro::TokenStream;

/// Inlines the native function at each call. For what every evaluation of a common tree goes through: the
/// vectors between such functions then stay in registers.
#[proc_macro_attribute]
pub fn always(_: TokenStream, item: TokenStream) -> TokenStream {
    let attribute: TokenStream = "#[inline(always)]".parse().expect("an attribute");
    attribute.into_iter().chain(item).collect()
}
