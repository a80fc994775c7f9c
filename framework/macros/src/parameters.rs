//! Attributes on a type that holds parameters.

use proc_macro::TokenStream;
use proc_macro2::TokenStream as Tokens;
use quote::{format_ident, quote};
use syn::{
    Attribute, Data, DeriveInput, Error, Expr, Field, Ident, LitStr, Token, Type,
    parse::{Parse, ParseStream, Parser},
    parse_macro_input,
};

/// `"tag"`, and what may follow.
struct Arguments {
    tag: LitStr,
    weight: Option<Expr>,
}

impl Parse for Arguments {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let wanted = "takes the plug-in's tag as a string, as in #[wbqp::task(\"posture\")]";
        let tag: LitStr = input
            .parse()
            .map_err(|error| Error::new(error.span(), format!("the attribute {wanted}")))?;
        if tag.value().is_empty() {
            return Err(Error::new(tag.span(), "the tag is empty"));
        }
        let mut weight = None;
        if input.parse::<Option<Token![,]>>()?.is_some() && !input.is_empty() {
            let key: Ident = input.parse()?;
            if key != "weight" {
                return Err(Error::new(key.span(), "unknown; known is `weight = …`"));
            }
            input.parse::<Token![=]>()?;
            weight = Some(input.parse()?);
            input.parse::<Option<Token![,]>>()?;
        }
        Ok(Self { tag, weight })
    }
}

/// The parameters of a plug-in, and its registration.
pub(crate) fn plugin(kind: &str, arguments: TokenStream, item: TokenStream) -> TokenStream {
    let Arguments { tag, weight } = parse_macro_input!(arguments as Arguments);
    let mut item = parse_macro_input!(item as DeriveInput);
    if !matches!(item.data, Data::Struct(_)) || !item.generics.params.is_empty() {
        let problem =
            "the attribute goes on a struct without type parameters: the plug-in's parameters";
        return Error::new_spanned(&item.ident, problem)
            .into_compile_error()
            .into();
    }
    if let Some(weight) = &weight
        && !["Task", "Constraint"].contains(&kind)
    {
        let problem = "only tasks and constraints have a weight";
        return Error::new_spanned(weight, problem)
            .into_compile_error()
            .into();
    }
    let weight = weight.map(|weight| quote!(, extend("x-weight" = #weight)));
    let defaults = match derive(&mut item, weight.as_ref()) {
        Ok(defaults) => defaults,
        Err(error) => return error.into_compile_error().into(),
    };
    let name = &item.ident;
    let (any, registered) = (format_ident!("Any{kind}"), format_ident!("{kind}Plugin"));
    let methods = match kind {
        "Reference" => quote! {
            fn bind_any(
                &self,
                space: ::wbqp::plugin::Space,
            ) -> ::core::result::Result<::wbqp::plugin::BoundReference, ::wbqp::error::BindError> {
                ::wbqp::plugin::BoundReference::new(self, space)
            }

            fn named_values(&self) -> ::std::vec::Vec<(::std::string::String, &[f64])> {
                ::wbqp::plugin::Reference::values(self)
            }

            fn boxed(&self) -> ::std::boxed::Box<dyn ::wbqp::plugin::AnyReference> {
                ::std::boxed::Box::new(::core::clone::Clone::clone(self))
            }
        },
        "FallbackLaw" => quote! {
            fn bind_any(
                &self,
                setup: &mut ::wbqp::plugin::Setup<'_>,
            ) -> ::core::result::Result<::wbqp::plugin::BoundFallbackLaw, ::wbqp::error::BindError> {
                ::wbqp::plugin::BoundFallbackLaw::new(self, setup)
            }
        },
        _ => {
            let bound = format_ident!("{}", kind.to_lowercase());
            quote! {
                fn bind_any(
                    &self,
                    setup: &mut ::wbqp::plugin::Setup<'_>,
                ) -> ::core::result::Result<::wbqp::plugin::BoundPlugin, ::wbqp::error::BindError> {
                    ::wbqp::plugin::BoundPlugin::#bound(self, setup)
                }
            }
        }
    };
    // What can be inside another plug-in, or be added while the program runs, is read through the registry.
    let tagged = if kind == "FallbackLaw" {
        quote!(typetag::serde)
    } else {
        quote!(typetag::serialize)
    };
    quote! {
        #item
        #defaults
        const _: () = {
            use ::wbqp::typetag;
            #[#tagged(name = #tag)]
            impl ::wbqp::plugin::#any for #name {
                #methods
            }
            ::wbqp::inventory::submit! {
                ::wbqp::registry::#registered::of::<#name>(
                    #tag, concat!(env!("CARGO_PKG_NAME"), " ", file!(), ":", line!()),
                )
            }
        };
    }
    .into()
}

/// A part of a plug-in's parameters.
pub(crate) fn part(arguments: &TokenStream, item: TokenStream) -> TokenStream {
    let mut item = parse_macro_input!(item as DeriveInput);
    if !arguments.is_empty() {
        return Error::new_spanned(&item.ident, "the attribute takes nothing")
            .into_compile_error()
            .into();
    }
    match derive(&mut item, None) {
        Ok(defaults) => quote!(#item #defaults).into(),
        Err(error) => error.into_compile_error().into(),
    }
}

/// Adds the derives, and turns the attributes of fields into those of serde and schemars; the functions that return
/// the fields' defaults.
fn derive(item: &mut DeriveInput, more: Option<&Tokens>) -> syn::Result<Tokens> {
    let name = item.ident.clone();
    let mut defaults = Vec::new();
    let rule = match &mut item.data {
        Data::Struct(data) => {
            for field in &mut data.fields {
                defaults.extend(translate(&name, field)?);
            }
            quote!(deny_unknown_fields)
        }
        Data::Enum(_) => quote!(rename_all = "snake_case"),
        Data::Union(_) => {
            return Err(Error::new_spanned(
                name,
                "parameters are a struct or an enum",
            ));
        }
    };
    let derives: [Attribute; 3] = [
        syn::parse_quote!(#[derive(
            ::core::clone::Clone,
            ::core::fmt::Debug,
            ::wbqp::serde::Serialize,
            ::wbqp::serde::Deserialize,
            ::wbqp::schemars::JsonSchema,
        )]),
        syn::parse_quote!(#[serde(crate = "::wbqp::serde", #rule)]),
        syn::parse_quote!(#[schemars(crate = "::wbqp::schemars" #more)]),
    ];
    // Before the struct's own attributes: helpers of a derive stand after it.
    item.attrs.splice(0..0, derives);
    Ok(if defaults.is_empty() {
        Tokens::new()
    } else {
        quote!(impl #name { #(#defaults)* })
    })
}

/// What a field is where it is left out.
#[derive(Default)]
enum WithoutIt {
    /// An error, unless its type says otherwise.
    #[default]
    Unsaid,
    /// Its type's default.
    OfType,
    Value(Box<Expr>),
}

/// What is said of a field.
#[derive(Default)]
struct Said {
    default: WithoutIt,
    unit: Option<LitStr>,
    critical: Option<LitStr>,
}

/// Replaces the attribute of a field; the function that returns its default, if it has one of its own.
fn translate(owner: &Ident, field: &mut Field) -> syn::Result<Option<Tokens>> {
    let mut said = Said::default();
    for attribute in &field.attrs {
        if attribute.path().is_ident("wbqp") {
            attribute.parse_nested_meta(|meta| {
                if meta.path.is_ident("default") {
                    said.default = if meta.input.peek(Token![=]) {
                        WithoutIt::Value(Box::new(meta.value()?.parse()?))
                    } else {
                        WithoutIt::OfType
                    };
                } else if meta.path.is_ident("unit") {
                    said.unit = Some(meta.value()?.parse()?);
                } else if meta.path.is_ident("critical") {
                    said.critical = Some(meta.value()?.parse()?);
                } else {
                    let known = "unknown; known are `default`, `default = …`, `unit = \"…\"`, `critical = \"…\"`";
                    return Err(meta.error(known));
                }
                Ok(())
            })?;
        }
    }
    field.attrs.retain(|a| !a.path().is_ident("wbqp"));
    let attributes = |tokens: Tokens| Attribute::parse_outer.parse2(tokens);
    let mut function = None;
    match &said.default {
        WithoutIt::Value(value) => {
            let (Some(name), ty) = (&field.ident, &field.ty) else {
                return Err(Error::new_spanned(field, "the field has no name"));
            };
            let default = format_ident!("default_{name}");
            let path = format!("{owner}::{default}");
            field
                .attrs
                .extend(attributes(quote!(#[serde(default = #path)]))?);
            function = Some(quote! {
                #[allow(clippy::useless_conversion)]
                fn #default() -> #ty {
                    ::core::convert::Into::into(#value)
                }
            });
        }
        _ if is_option(&field.ty) => field.attrs.extend(attributes(
            quote!(#[serde(default, skip_serializing_if = "Option::is_none")]),
        )?),
        WithoutIt::OfType => field.attrs.extend(attributes(quote!(#[serde(default)]))?),
        WithoutIt::Unsaid => {}
    }
    if let Some(unit) = said.unit {
        let unit = quote!(#[schemars(extend("x-unit" = #unit))]);
        field.attrs.extend(attributes(unit)?);
    }
    if let Some(stiffness) = said.critical {
        let critical = quote!(#[schemars(extend("x-critical" = #stiffness))]);
        field.attrs.extend(attributes(critical)?);
    }
    Ok(function)
}

fn is_option(ty: &Type) -> bool {
    matches!(ty, Type::Path(path) if path.path.segments.last().is_some_and(|s| s.ident == "Option"))
}
