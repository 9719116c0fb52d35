"""Mutants of a source file: cosmic-ray's operators, less those that say nothing about tests of numerics."""

import ast
import random
import re
from pathlib import Path
from typing import NamedTuple

#: Replacements that a float cannot survive (shifts, bits), or that fail wherever they run, would only flatter the share.
KEPT = re.compile(r"core/(ReplaceBinaryOperator_(Add|Sub|Mul|Div)_(Add|Sub|Mul|Div)|ReplaceBinaryOperator_Pow_Mul|ReplaceBinaryOperator_Mod_Mul"
                  r"|ReplaceBinaryOperator_FloorDiv_Mul|ReplaceBinaryOperator_Bit(Or_BitAnd|And_BitOr)"
                  r"|ReplaceComparisonOperator_(?!Is)\w+_(?!Is)\w+|ReplaceUnaryOperator_(USub_UAdd|Delete_\w+)|AddNot|ReplaceTrueWithFalse"
                  r"|ReplaceFalseWithTrue|ReplaceAndWithOr|ReplaceOrWithAnd|ReplaceBreakWithContinue|ReplaceContinueWithBreak|NumberReplacer"
                  r"|ZeroIterationForLoop)$")


class Mutant(NamedTuple):
    """One change of one module: the operator and which of its places."""

    module: str
    operator: str
    place: int

    def __str__(self) -> str:
        return f"{self.module} {self.operator.removeprefix('core/')}:{self.place}"


def code_of(source: str) -> str:
    """Return what of a source is run: no annotations and no docstrings."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.AnnAssign):
            node.annotation = ast.Constant(None)
        elif isinstance(node, ast.arg):
            node.annotation = None
        elif isinstance(node, ast.FunctionDef):
            node.returns = None
    return ast.dump(tree)


def mutants(root: Path, module: str) -> list[Mutant]:
    """Return every mutant of a module."""
    from cosmic_ray.ast import ast_nodes, get_ast
    from cosmic_ray.plugins import get_operator, operator_names

    tree = get_ast((root / module).read_text(encoding="utf-8"))
    found = []
    for name in sorted(filter(KEPT.match, operator_names())):
        operator = get_operator(name)()
        places = sum(1 for node in ast_nodes(tree) for _ in operator.mutation_positions(node))
        found += [Mutant(module, name, place) for place in range(places)]
    return found


def mutated(root: Path, mutant: Mutant) -> str | None:
    """Return the source with the change, or None where it changes nothing that runs."""
    from cosmic_ray.mutating import mutate_code
    from cosmic_ray.plugins import get_operator

    source = (root / mutant.module).read_text(encoding="utf-8")
    changed = mutate_code(source, get_operator(mutant.operator)(), mutant.place)
    return changed if changed is not None and code_of(changed) != code_of(source) else None


def sample(root: Path, modules: list[str], count: int, seed: int) -> tuple[list[Mutant], int]:
    """Return ``count`` mutants of the modules, drawn without replacement, and how many there are to draw from."""
    everything = [mutant for module in modules for mutant in mutants(root, module)]
    shuffled = random.Random(seed).sample(everything, len(everything))
    chosen: list[Mutant] = []
    for mutant in shuffled:
        if len(chosen) == count:
            break
        if mutated(root, mutant) is not None:
            chosen.append(mutant)
    return chosen, len(everything)
