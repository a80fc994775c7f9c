//! The attributes that make a type a wbqp plug-in.
//!
//! `#[wbqp::task("posture")] impl Task for Posture { … }` gives the type its `typetag` name, so that
//! `Box<dyn Task>` serialises, and its place in wbqp's registry, where the configuration loader finds it with
//! its JSON Schema and its origin. The type must be `Serialize + Deserialize + JsonSchema`.

use proc_macro::{Delimiter, Group, Ident, Literal, Punct, Spacing, Span, TokenStream, TokenTree};

/// Registers an `impl Task for …` under the given tag.
#[proc_macro_attribute]
pub fn task(tag: TokenStream, item: TokenStream) -> TokenStream {
    register("Task", tag, &item)
}

/// Registers an `impl Constraint for …` under the given tag.
#[proc_macro_attribute]
pub fn constraint(tag: TokenStream, item: TokenStream) -> TokenStream {
    register("Constraint", tag, &item)
}

/// Registers an `impl Reference for …` under the given tag.
#[proc_macro_attribute]
pub fn reference(tag: TokenStream, item: TokenStream) -> TokenStream {
    register("Reference", tag, &item)
}

/// Registers an `impl Robot for …` under the given tag.
#[proc_macro_attribute]
pub fn robot(tag: TokenStream, item: TokenStream) -> TokenStream {
    register("Robot", tag, &item)
}

/// Registers an `impl Solver for …` under the given tag.
#[proc_macro_attribute]
pub fn solver(tag: TokenStream, item: TokenStream) -> TokenStream {
    register("Solver", tag, &item)
}

/// Emits the implementation with its typetag name, and a registration of the implementing type.
fn register(kind: &str, tag: TokenStream, item: &TokenStream) -> TokenStream {
    let Some(tag) = tag_literal(tag) else {
        return error(
            "the attribute takes the plug-in's tag as one string, as in #[wbqp::task(\"posture\")]",
        );
    };
    let Some(implementor) = implementing_type(item) else {
        return error("the attribute goes on an `impl Trait for Type` block");
    };
    let source = format!(
        "const _: () = {{
            use ::wbqp::typetag;
            #[typetag::serde(name = {tag})]
            __ITEM__
            ::wbqp::inventory::submit! {{
                ::wbqp::registry::{kind}Plugin::of::<__TYPE__>(
                    {tag}, concat!(env!(\"CARGO_PKG_NAME\"), \" \", file!(), \":\", line!()),
                )
            }}
        }};"
    );
    match source.parse::<TokenStream>() {
        Ok(template) => substitute(template, item, &implementor),
        Err(_) => error("the tag is not a plain string"),
    }
}

/// The one string literal of the attribute; a `$tag:literal` of a `macro_rules!` comes in an invisible group.
fn tag_literal(tag: TokenStream) -> Option<Literal> {
    let mut tokens = tag.into_iter();
    match (tokens.next(), tokens.next()) {
        (Some(TokenTree::Literal(tag)), None) => {
            let text = tag.to_string();
            (text.starts_with('"') && text != "\"\"").then_some(tag)
        }
        (Some(TokenTree::Group(group)), None) if group.delimiter() == Delimiter::None => {
            tag_literal(group.stream())
        }
        _ => None,
    }
}

/// The tokens between the last top-level `for` and the body's braces.
fn implementing_type(item: &TokenStream) -> Option<TokenStream> {
    let mut tokens: Vec<TokenTree> = item.clone().into_iter().collect();
    let body = tokens.pop()?;
    let is_body = matches!(&body, TokenTree::Group(g) if g.delimiter() == Delimiter::Brace);
    let position = tokens
        .iter()
        .rposition(|t| matches!(t, TokenTree::Ident(i) if i.to_string() == "for"))?;
    let implementor: TokenStream = tokens.drain(position + 1..).collect();
    (is_body && !implementor.is_empty()).then_some(implementor)
}

/// Replaces the two placeholders, keeping the spans of the user's own code.
fn substitute(template: TokenStream, item: &TokenStream, implementor: &TokenStream) -> TokenStream {
    template
        .into_iter()
        .flat_map(|token| match token {
            TokenTree::Ident(i) if i.to_string() == "__ITEM__" => item.clone(),
            TokenTree::Ident(i) if i.to_string() == "__TYPE__" => implementor.clone(),
            TokenTree::Group(g) => {
                let inner = substitute(g.stream(), item, implementor);
                let mut group = Group::new(g.delimiter(), inner);
                group.set_span(g.span());
                TokenTree::Group(group).into()
            }
            other => other.into(),
        })
        .collect()
}

fn error(message: &str) -> TokenStream {
    let mut tokens: Vec<TokenTree> = vec![
        Ident::new("compile_error", Span::call_site()).into(),
        Punct::new('!', Spacing::Alone).into(),
    ];
    let text = Literal::string(message);
    tokens.push(Group::new(Delimiter::Parenthesis, TokenTree::from(text).into()).into());
    tokens.push(Punct::new(';', Spacing::Alone).into());
    tokens.into_iter().collect()
}
