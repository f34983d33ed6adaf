//! The modules of a crate, and which of them use which: what the compiler would see, tests left out.
//!
//! Read are `use`, paths in expressions, types and patterns, and what looks like a path in macros and attributes. A name
//! that a module passes on (`pub use`) is followed to the module that defines it. What is used without being named (a
//! method, a field) is not seen: whoever has such a value has its type from somewhere.

use super::circles::{Circle, Edge, circles};
use proc_macro2::{Ident, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use syn::ext::IdentExt;
use syn::visit::{self, Visit};

/// Names from the crate's root; that of the root has none.
type ModulePath = Vec<String>;

/// One module names another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Use {
    pub from: ModulePath,
    pub to: ModulePath,
    /// File, line and what stands there.
    pub place: String,
}

/// What a name stands for in a module.
#[derive(Debug, Clone, PartialEq)]
enum Meaning {
    Module,
    /// Something else that is defined there.
    Own,
    /// What this path, seen from there, stands for.
    Alias(Vec<String>),
}

#[derive(Debug, Default)]
struct Module {
    names: BTreeMap<String, Vec<Meaning>>,
    /// Whose names are all imported.
    globs: Vec<Vec<String>>,
    named: Vec<Named>,
}

/// A path, as it stands in the source.
#[derive(Debug)]
struct Named {
    path: Vec<String>,
    of_macro: bool,
    place: String,
}

/// A crate, read.
#[derive(Debug, Default)]
pub struct Crate {
    modules: BTreeMap<ModulePath, Module>,
    /// By `macro_rules!`: they are known to all that comes after them.
    macros: BTreeMap<String, ModulePath>,
}

impl Crate {
    /// Reads a crate from the file of its root on; `read` gives the text of a file that there is.
    pub fn read(root: &Path, read: &dyn Fn(&Path) -> Option<String>) -> Crate {
        let mut all = Crate::default();
        let place =
            Place { module: Vec::new(), file: root.to_owned(), children: parent(root), braces: false };
        all.read_file(&place, read);
        all
    }

    fn read_file(&mut self, place: &Place, read: &dyn Fn(&Path) -> Option<String>) {
        let name = place.file.display();
        let text = read(&place.file).unwrap_or_else(|| panic!("{name}: there is no such file"));
        let file = syn::parse_file(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
        if !is_for_tests(&file.attrs) {
            self.read_items(place, &file.items, read);
        }
    }

    fn read_items(&mut self, place: &Place, items: &[syn::Item], read: &dyn Fn(&Path) -> Option<String>) {
        self.modules.entry(place.module.clone()).or_default();
        for item in items.iter().filter(|item| !is_for_tests(attributes(item))) {
            if let Some(name) = name(item) {
                let meaning = if matches!(item, syn::Item::Mod(_)) { Meaning::Module } else { Meaning::Own };
                self.module(place).mean(name, meaning);
            }
            match item {
                syn::Item::Mod(module) => self.read_module(place, module, read),
                _ => {
                    if let syn::Item::Macro(syn::ItemMacro { ident: Some(ident), attrs, .. }) = item {
                        self.define_macro(place, ident, attrs);
                    }
                    let mut reader = Reader { place, found: self.module(place) };
                    reader.visit_item(item);
                }
            }
        }
    }

    fn read_module(&mut self, place: &Place, module: &syn::ItemMod, read: &dyn Fn(&Path) -> Option<String>) {
        let name = module.ident.unraw().to_string();
        let path = [&place.module[..], std::slice::from_ref(&name)].concat();
        let own = place.children.join(&name);
        if let Some((_, items)) = &module.content {
            let inside = Place { module: path, file: place.file.clone(), children: own, braces: true };
            return self.read_items(&inside, items, read);
        }
        let inside = match path_attribute(&module.attrs) {
            Some(given) => {
                let file =
                    if place.braces { place.children.join(given) } else { parent(&place.file).join(given) };
                Place { module: path, children: parent(&file), file, braces: false }
            }
            None => {
                let beside = own.with_extension("rs");
                let file = if read(&beside).is_some() { beside } else { own.join("mod.rs") };
                Place { module: path, file, children: own, braces: false }
            }
        };
        self.read_file(&inside, read);
    }

    fn define_macro(&mut self, place: &Place, ident: &Ident, attributes: &[syn::Attribute]) {
        let name = ident.unraw().to_string();
        self.macros.insert(name.clone(), place.module.clone());
        if attributes.iter().any(|attribute| attribute.path().is_ident("macro_export")) {
            let path = [&["crate".to_owned()], &place.module[..], std::slice::from_ref(&name)].concat();
            self.modules.entry(Vec::new()).or_default().mean(name, Meaning::Alias(path));
        }
    }

    fn module(&mut self, place: &Place) -> &mut Module {
        self.modules.get_mut(&place.module).unwrap()
    }

    /// Every module.
    pub fn modules(&self) -> impl Iterator<Item = &[String]> {
        self.modules.keys().map(|path| &path[..])
    }

    /// Who names whom; a module is named by who goes through it, too.
    pub fn uses(&self) -> Vec<Use> {
        let mut uses = Vec::new();
        for (from, module) in &self.modules {
            for named in &module.named {
                let mut trace = Trace::default();
                self.follow(from, &named.path, &mut trace);
                let mut to = trace.through;
                if let (true, [name]) = (named.of_macro && to.is_empty(), &named.path[..]) {
                    to.extend(self.macros.get(name).cloned());
                }
                let place = &named.place;
                uses.extend(to.into_iter().map(|to| Use { from: from.clone(), to, place: place.clone() }));
            }
        }
        uses
    }

    /// What modules below a path name that is of other crates, and where.
    pub fn foreign(&self, below: &[String]) -> Vec<(&[String], &str)> {
        let inside = self.modules.iter().filter(|(path, _)| path.starts_with(below));
        let named = inside.flat_map(|(path, module)| module.named.iter().map(move |named| (path, named)));
        let foreign = named.filter(|(from, named)| {
            named.path.len() > 1 && !self.follow(from, &named.path[..1], &mut Trace::default())
        });
        foreign.map(|(_, named)| (&named.path[..], &named.place[..])).collect()
    }

    /// Adds the modules that a path leads through to the one that defines what it stands for; whether it leads
    /// anywhere in this crate.
    fn follow(&self, from: &[String], path: &[String], trace: &mut Trace) -> bool {
        let mut at = from.to_owned();
        let mut rest = path;
        while let Some((first, after)) = rest.split_first() {
            match first.as_str() {
                "crate" => at.clear(),
                "self" => {}
                "super" => _ = at.pop(),
                _ => break,
            }
            rest = after;
        }
        let named_by_place = rest.len() < path.len();
        if named_by_place {
            trace.through.insert(at.clone());
        }
        // What is not found is made by a macro.
        self.follow_names(&at, rest, trace) || named_by_place
    }

    fn follow_names(&self, at: &[String], names: &[String], trace: &mut Trace) -> bool {
        let (Some(module), Some((name, after))) = (self.modules.get(at), names.split_first()) else {
            return false;
        };
        let mut found = false;
        for meaning in module.names.get(name).into_iter().flatten() {
            match meaning {
                Meaning::Own => {
                    trace.through.insert(at.to_owned());
                    found = true;
                }
                Meaning::Alias(path) => {
                    // What it stands for is not found by itself: in `use grid::grid` the first is a module.
                    let goes_on = |trace: &mut Trace| self.follow(at, &[path, after].concat(), trace);
                    found |= trace.once(at, path, goes_on);
                }
                Meaning::Module => {
                    let inside = [at, std::slice::from_ref(name)].concat();
                    trace.through.insert(inside.clone());
                    self.follow_names(&inside, after, trace);
                    found = true;
                }
            }
        }
        // A name of a module's own hides those of a glob.
        if !found {
            for glob in &module.globs {
                let goes_on = |trace: &mut Trace| {
                    self.knows(at, glob, name, trace) && self.follow(at, &[glob, names].concat(), trace)
                };
                found |= trace.once(at, glob, goes_on);
            }
        }
        found
    }

    /// Whether a module that a glob leads through has a name, of its own or by a glob of its own.
    fn knows(&self, at: &[String], glob: &[String], name: &str, trace: &Trace) -> bool {
        let mut there = trace.clone();
        there.through.clear();
        self.follow(at, glob, &mut there);
        let modules = std::mem::take(&mut there.through);
        modules.iter().any(|module| self.follow_names(module, &[name.to_owned()], &mut there))
    }

    /// Circles between modules that have the same parent, each counted as one with all that is in it. What a module uses
    /// of those around it or in it makes no circle.
    pub fn circles(&self) -> Vec<(ModulePath, Circle)> {
        let mut levels: BTreeMap<ModulePath, Vec<Edge>> = BTreeMap::new();
        for Use { from, to, place } in self.uses() {
            let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
            if let (Some(one), Some(other)) = (from.get(common), to.get(common)) {
                let edge = Edge { from: one.clone(), to: other.clone(), place };
                levels.entry(from[..common].to_owned()).or_default().push(edge);
            }
        }
        let of_level = |(level, edges): (ModulePath, Vec<Edge>)| {
            circles(edges).into_iter().map(move |circle| (level.clone(), circle))
        };
        levels.into_iter().flat_map(of_level).collect()
    }
}

/// What following a path has come through.
#[derive(Debug, Clone, Default)]
struct Trace {
    through: BTreeSet<ModulePath>,
    /// Imports that are being followed, by where they stand: they may lead in circles.
    under_way: BTreeSet<(ModulePath, Vec<String>)>,
}

impl Trace {
    /// Does it unless this import is being followed already.
    fn once(&mut self, at: &[String], path: &[String], follow: impl FnOnce(&mut Trace) -> bool) -> bool {
        let import = (at.to_owned(), path.to_owned());
        if !self.under_way.insert(import.clone()) {
            return false;
        }
        let found = follow(self);
        self.under_way.remove(&import);
        found
    }
}

impl Module {
    fn mean(&mut self, name: impl Into<String>, meaning: Meaning) {
        let known = self.names.entry(name.into()).or_default();
        if !known.contains(&meaning) {
            known.push(meaning);
        }
    }
}

/// Where items stand.
struct Place {
    module: ModulePath,
    file: PathBuf,
    /// The directory of the modules inside.
    children: PathBuf,
    /// The module is a part of its file.
    braces: bool,
}

fn parent(file: &Path) -> PathBuf {
    file.parent().unwrap().to_owned()
}

/// Notes what the items of a module name.
struct Reader<'a> {
    place: &'a Place,
    found: &'a mut Module,
}

impl Reader<'_> {
    fn name(&mut self, path: Vec<String>, line: usize, of_macro: bool) {
        let place = format!("{}:{line}: {}", self.place.file.display(), path.join("::"));
        self.found.named.push(Named { path, of_macro, place });
    }

    fn import(&mut self, tree: &syn::UseTree, before: &[String]) {
        let with = |ident: &Ident| [before, &[ident.unraw().to_string()]].concat();
        match tree {
            syn::UseTree::Path(part) => self.import(&part.tree, &with(&part.ident)),
            syn::UseTree::Group(group) => group.items.iter().for_each(|tree| self.import(tree, before)),
            syn::UseTree::Name(leaf) if leaf.ident == "self" => {
                self.bind(before.last().unwrap().clone(), before.to_owned(), &leaf.ident);
            }
            syn::UseTree::Name(leaf) => {
                self.bind(leaf.ident.unraw().to_string(), with(&leaf.ident), &leaf.ident)
            }
            syn::UseTree::Rename(leaf) => {
                let path = if leaf.ident == "self" { before.to_owned() } else { with(&leaf.ident) };
                self.bind(leaf.rename.unraw().to_string(), path, &leaf.ident);
            }
            syn::UseTree::Glob(glob) => {
                let line = glob.star_token.span.start().line;
                self.found.globs.push(before.to_owned());
                self.name(before.to_owned(), line, false);
            }
        }
    }

    fn bind(&mut self, name: String, path: Vec<String>, at: &Ident) {
        // `use say;` of a macro.
        if path != [name.clone()] {
            self.found.mean(name, Meaning::Alias(path.clone()));
        }
        self.name(path, at.span().start().line, false);
    }

    /// What looks like a path.
    fn tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<Ident> = Vec::new();
        // Of the colons since the last name.
        let mut colons = 0;
        let mut before = ' ';
        for token in tokens {
            let goes_on = colons == 2 && !path.is_empty();
            match token {
                TokenTree::Punct(mark) if mark.as_char() == ':' => {
                    colons += 1;
                    before = ':';
                    continue;
                }
                TokenTree::Ident(ident) if goes_on => path.push(ident),
                TokenTree::Ident(ident) => {
                    self.finish(&mut path);
                    // A field or a method; a lifetime; a name that the macro is given.
                    let no_path = ['.', '\''].contains(&before) || (before == '$' && ident != "crate");
                    if !no_path {
                        path.push(ident);
                    }
                }
                TokenTree::Group(group) => {
                    self.finish(&mut path);
                    self.tokens(group.stream());
                }
                TokenTree::Punct(mark) => {
                    self.finish(&mut path);
                    before = mark.as_char();
                    colons = 0;
                    continue;
                }
                TokenTree::Literal(_) => self.finish(&mut path),
            }
            colons = 0;
            before = ' ';
        }
        self.finish(&mut path);
    }

    fn finish(&mut self, path: &mut Vec<Ident>) {
        if let Some(first) = path.first() {
            let line = first.span().start().line;
            self.name(path.drain(..).map(|ident| ident.unraw().to_string()).collect(), line, false);
        }
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if !is_for_tests(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        if !is_for_tests(&item.attrs) {
            visit::visit_impl_item_fn(self, item);
        }
    }

    fn visit_local(&mut self, local: &'ast syn::Local) {
        if !is_for_tests(&local.attrs) {
            visit::visit_local(self, local);
        }
    }

    fn visit_field(&mut self, field: &'ast syn::Field) {
        if !is_for_tests(&field.attrs) {
            visit::visit_field(self, field);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        if item.leading_colon.is_none() {
            self.import(&item.tree, &[]);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        if path.leading_colon.is_none() {
            let line = path.segments[0].ident.span().start().line;
            let names = path.segments.iter().map(|segment| segment.ident.unraw().to_string());
            self.name(names.collect(), line, false);
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        let line = call.path.segments[0].ident.span().start().line;
        let names = call.path.segments.iter().map(|segment| segment.ident.unraw().to_string());
        self.name(names.collect(), line, true);
        self.tokens(call.tokens.clone());
    }

    fn visit_attribute(&mut self, attribute: &'ast syn::Attribute) {
        match &attribute.meta {
            syn::Meta::List(list) => {
                self.tokens(list.tokens.clone());
                if list.path.is_ident("serde") {
                    // #[serde(with = "crate::times")]
                    paths_in_words(list.tokens.clone()).into_iter().for_each(|tokens| self.tokens(tokens));
                }
            }
            syn::Meta::NameValue(pair) if !pair.path.is_ident("doc") => self.visit_expr(&pair.value),
            _ => {}
        }
    }
}

fn paths_in_words(tokens: TokenStream) -> Vec<TokenStream> {
    let words = tokens.into_iter().filter_map(|token| match token {
        TokenTree::Literal(literal) => syn::parse_str::<syn::LitStr>(&literal.to_string()).ok(),
        _ => None,
    });
    words.filter_map(|word| word.parse::<TokenStream>().ok()).collect()
}

fn path_attribute(attributes: &[syn::Attribute]) -> Option<String> {
    let path = attributes.iter().find(|attribute| attribute.path().is_ident("path"))?;
    match &path.meta.require_name_value().ok()?.value {
        syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. }) => Some(text.value()),
        _ => None,
    }
}

/// Whether what has these attributes is there in tests only.
fn is_for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        syn::Meta::Path(path) => path.is_ident("test"),
        syn::Meta::List(list) if list.path.is_ident("cfg") => {
            list.parse_args::<syn::Meta>().is_ok_and(|condition| needs_test(&condition))
        }
        _ => false,
    })
}

/// `test`, or `all` of some conditions of which one is.
fn needs_test(condition: &syn::Meta) -> bool {
    match condition {
        syn::Meta::Path(path) => path.is_ident("test"),
        syn::Meta::List(list) if list.path.is_ident("all") => {
            let several = syn::punctuated::Punctuated::<syn::Meta, syn::Token![,]>::parse_terminated;
            list.parse_args_with(several).is_ok_and(|all| all.iter().any(needs_test))
        }
        _ => false,
    }
}

fn attributes(item: &syn::Item) -> &[syn::Attribute] {
    use syn::Item;
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::ExternCrate(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::ForeignMod(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::TraitAlias(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

/// The name that an item gives to something.
fn name(item: &syn::Item) -> Option<String> {
    use syn::Item;
    let ident = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Macro(item) => item.ident.as_ref()?,
        Item::Mod(item) => &item.ident,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::TraitAlias(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(ident.unraw().to_string())
}
