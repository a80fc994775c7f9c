//! Attributes on an `impl Trait for Type`.

use proc_macro::TokenStream;
use quote::{format_ident, quote};
use syn::{ItemImpl, LitStr, parse_macro_input};

/// Emits the implementation with its typetag name, and a registration of the implementing type.
pub(crate) fn register(kind: &str, tag: TokenStream, item: TokenStream) -> TokenStream {
    let tag = parse_macro_input!(tag as LitStr);
    let item = parse_macro_input!(item as ItemImpl);
    let implementor = &item.self_ty;
    let plugin = format_ident!("{kind}Plugin");
    quote! {
        const _: () = {
            use ::wbqp::typetag;
            #[typetag::serde(name = #tag)]
            #item
            ::wbqp::inventory::submit! {
                ::wbqp::registry::#plugin::of::<#implementor>(
                    #tag, concat!(env!("CARGO_PKG_NAME"), " ", file!(), ":", line!()),
                )
            }
        };
    }
    .into()
}
