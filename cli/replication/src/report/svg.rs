//! Figures inside of a page.

/// A figure's file as an element of a page: without what comes before the element, and with ids of its own, because ids
/// are the page's.
pub(super) fn inline(file: &str, prefix: &str) -> String {
    let element = file.find("<svg").map_or("", |start| &file[start..]);
    let mut text = element.trim_end().to_owned();
    for quote in ['"', '\''] {
        for before in ["id=", "href="] {
            let mark = if before == "href=" { "#" } else { "" };
            let old = format!(" {before}{quote}{mark}");
            text = text.replace(&old, &format!("{old}{prefix}-"));
        }
    }
    text.replace("url(#", &format!("url(#{prefix}-"))
}

#[cfg(test)]
mod tests {
    use super::inline;

    #[test]
    fn ids_and_references_get_the_prefix() {
        let file = "<?xml version=\"1.0\"?>\n<svg width=\"9\"><clipPath id=\"a\"/>\
                    <g clip-path=\"url(#a)\"/><use href=\"#a\"/></svg>\n";
        assert_eq!(
            inline(file, "f"),
            "<svg width=\"9\"><clipPath id=\"f-a\"/><g clip-path=\"url(#f-a)\"/><use href=\"#f-a\"/></svg>"
        );
        assert_eq!(inline("no figure", "f"), "");
    }
}
