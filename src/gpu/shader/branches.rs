//! Finds branches that uniforms alone decide.
//!
//! A driver may make such uniforms constants of its code and compile it again whenever they are bound: Mesa's software
//! driver (22.3) does, with every frame, and keeps all it compiled. Where a branch has to hang on a setting, the setting
//! lies in a storage buffer.

use naga::{AddressSpace, Block, Expression, Function, Handle, Module, Statement};

/// Names of the functions of a module that have a branch whose condition reads uniforms and nothing else but constants
/// and counters.
pub(super) fn on_uniforms(module: &Module) -> Vec<String> {
    let functions = module.functions.iter().map(|(_, f)| f);
    let entries = module.entry_points.iter().map(|e| &e.function);
    functions
        .chain(entries)
        .filter(|f| block_has(module, f, &f.body))
        .map(|f| f.name.clone().unwrap_or_default())
        .collect()
}

fn block_has(module: &Module, function: &Function, block: &Block) -> bool {
    let by_uniforms = |condition| {
        let mut reads = Reads::default();
        reads.gather(module, function, condition);
        reads.uniforms && !reads.others
    };
    let inner = |block| block_has(module, function, block);
    block.iter().any(|statement| match statement {
        Statement::Block(block) => inner(block),
        Statement::If {
            condition,
            accept,
            reject,
        } => by_uniforms(*condition) || inner(accept) || inner(reject),
        Statement::Switch { selector, cases } => {
            by_uniforms(*selector) || cases.iter().any(|case| inner(&case.body))
        }
        Statement::Loop {
            body,
            continuing,
            break_if,
        } => break_if.is_some_and(by_uniforms) || inner(body) || inner(continuing),
        _ => false,
    })
}

/// What an expression is made of.
#[derive(Default)]
struct Reads {
    /// Members of uniforms at places known beforehand.
    uniforms: bool,
    /// What no compiler knows beforehand; local variables are taken for counters.
    others: bool,
}

impl Reads {
    fn gather(&mut self, module: &Module, function: &Function, at: Handle<Expression>) {
        // Nothing more is to be learnt; and expressions share their parts.
        if self.others {
            return;
        }
        let mut gather = |at| self.gather(module, function, at);
        match function.expressions[at] {
            Expression::Literal(_)
            | Expression::Constant(_)
            | Expression::ZeroValue(_)
            | Expression::LocalVariable(_) => (),
            Expression::GlobalVariable(variable) => match module.global_variables[variable].space {
                AddressSpace::Uniform => self.uniforms = true,
                _ => self.others = true,
            },
            Expression::Load { pointer: inner }
            | Expression::AccessIndex { base: inner, .. }
            | Expression::Splat { value: inner, .. }
            | Expression::Swizzle { vector: inner, .. }
            | Expression::Unary { expr: inner, .. }
            | Expression::Relational {
                argument: inner, ..
            }
            | Expression::As { expr: inner, .. } => gather(inner),
            Expression::Binary { left, right, .. } => {
                gather(left);
                gather(right);
            }
            Expression::Compose { ref components, .. } => {
                components.iter().copied().for_each(gather);
            }
            Expression::Select {
                condition,
                accept,
                reject,
            } => [condition, accept, reject].into_iter().for_each(gather),
            // Arguments, calls, textures, places computed on the way.
            _ => self.others = true,
        }
    }
}

#[test]
fn a_branch_on_uniforms_alone_is_found() {
    let found = |condition: &str| {
        let text = format!(
            "struct Settings {{ on: u32, end: u32 }}
            @group(0) @binding(0) var<uniform> settings: Settings;
            @group(0) @binding(1) var<storage, read_write> out: array<u32>;
            @compute @workgroup_size(8) fn work(@builtin(local_invocation_index) at: u32) {{
                for (var i = 0u; {condition}; i++) {{ out[at] += 1u; }}
            }}"
        );
        on_uniforms(&naga::front::wgsl::parse_str(&text).unwrap()).len()
    };
    assert_eq!(found("i < settings.end"), 1);
    assert_eq!(found("(i < 3u) & (settings.on == 1u)"), 1);
    assert_eq!(found("i < 3u"), 0);
    assert_eq!(found("i + at < settings.end"), 0);
    assert_eq!(found("i < out[0]"), 0);
}
