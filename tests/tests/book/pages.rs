//! The pages, and the blocks of code in them.

use std::{
    fs,
    path::{Path, PathBuf},
};

use wbqp_tests::files::workspace;

/// A block of code.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// The page, relative to the repository, and the line of its first line of code.
    pub place: String,
    /// The page's folder, where relative paths in the block count from.
    pub folder: PathBuf,
    /// `toml`, `sh`, …
    pub language: String,
    /// What else the info string says: `fragment`, `ignore`, …
    pub marks: Vec<String>,
    pub text: String,
}

impl Block {
    pub(crate) fn is(&self, mark: &str) -> bool {
        self.marks.iter().any(|m| m == mark)
    }
}

/// All pages: those of the book, and the READMEs.
pub(crate) fn pages() -> Vec<PathBuf> {
    let mut pages = vec![workspace("README.md"), workspace("python/README.md")];
    collect(&workspace("docs"), &mut pages);
    pages.sort();
    assert!(pages.len() > 30, "only {} pages", pages.len());
    pages
}

fn collect(folder: &Path, pages: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("docs can be listed") {
        let path = entry.expect("can be listed").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        // What mdBook makes.
        if path.is_dir() && name != "book" && name != "files" {
            collect(&path, pages);
        } else if name.ends_with(".md") {
            pages.push(path);
        }
    }
}

/// What a page is called in messages.
pub(crate) fn name(page: &Path) -> String {
    let root = workspace("");
    page.strip_prefix(&root)
        .unwrap_or(page)
        .display()
        .to_string()
}

/// All blocks of a language.
pub(crate) fn blocks(language: &str) -> Vec<Block> {
    let all = pages()
        .iter()
        .flat_map(|page| blocks_of(page))
        .collect::<Vec<_>>();
    let found: Vec<Block> = all
        .into_iter()
        .filter(|block| block.language == language)
        .collect();
    assert!(!found.is_empty(), "no block in {language}");
    found
}

/// Blocks with a mark, each with the block behind it.
pub(crate) fn with_the_next(mark: &str) -> Vec<[Block; 2]> {
    let mut found = Vec::new();
    for page in pages() {
        let mut blocks = blocks_of(&page).into_iter().peekable();
        while let Some(block) = blocks.next() {
            if block.is(mark)
                && let Some(next) = blocks.next_if(|next| next.language == "text")
            {
                found.push([block, next]);
            }
        }
    }
    assert!(!found.is_empty(), "no block is marked `{mark}`");
    found
}

/// The blocks of a page; those in lists without their indentation.
fn blocks_of(page: &Path) -> Vec<Block> {
    let text = fs::read_to_string(page).unwrap_or_else(|e| panic!("{}: {e}", page.display()));
    let mut blocks = Vec::new();
    let mut open: Option<(Block, usize)> = None;
    for (number, line) in text.lines().enumerate() {
        let indent = line.len() - line.trim_start().len();
        let Some(info) = line.trim_start().strip_prefix("```") else {
            if let Some((block, indent)) = &mut open {
                let code = line.get((*indent).min(line.len())..).unwrap_or_default();
                block.text.push_str(code);
                block.text.push('\n');
            }
            continue;
        };
        if let Some((block, _)) = open.take() {
            blocks.push(block);
            continue;
        }
        let mut words = info.split(',').map(|word| word.trim().to_owned());
        let block = Block {
            place: format!("{}:{}", name(page), number + 2),
            folder: page.parent().expect("is in a folder").to_path_buf(),
            language: words.next().unwrap_or_default(),
            marks: words.collect(),
            text: String::new(),
        };
        open = Some((block, indent));
    }
    assert!(open.is_none(), "{}: a block does not end", page.display());
    blocks
}

#[test]
fn every_block_says_its_language() {
    for page in pages() {
        for block in blocks_of(&page) {
            let known = [
                "toml", "sh", "rust", "python", "text", "yaml", "json", "bash",
            ];
            assert!(
                known.contains(&block.language.as_str()),
                "{}: a block in `{}`",
                block.place,
                block.language
            );
        }
    }
}
