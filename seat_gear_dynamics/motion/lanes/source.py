"""Writes the source of a lane kernel: one Runge-Kutta step as straight-line code inside a loop over lanes.

Only the mesh forces are not linear. A step of (20)-(21) is therefore, exactly, a linear map of the state plus a linear
map of the forces of its four stages, and a force depends on the state only through the closing δ of its mesh and its
rate. The kernel forms δ and force stage by stage, then applies both maps once; the coefficients of the maps stand in
rows (see `structure`), a set for every lane (see `propagator`). Against the textbook form this saves arithmetic and
most of the chain of operations that wait for each other; numbers differ from it by rounding only.

Time is counted in half steps: V is a rate times half the step, an acceleration is times its square. The excitation is
then the same for lanes of every frequency and is read once for all, and no stage needs a factor of its own.

The two ends of a shaft pull at each other in every stage. A map would need coefficients for each pair of them, of their
forces and of stages, so they go through the four stages as the textbook has it, which is less arithmetic; all other
coordinates go by their maps.

A step has two loops: the first ends with the forces in scratch rows, the second moves the state. In one loop the
values held at a time would not fit a processor's vector registers.
"""

from collections.abc import Iterator
from itertools import chain

from seat_gear_dynamics.motion.lanes.structure import PER_MESH, STAGES, Structure

EXCITATION = ("kappa", "error", "slope")
"""Columns of the excitation of a mesh: κ, e, and the slope of e per half step."""
_HALF_STEP = {1: 0, 2: 1, 3: 1, 4: 2}  # where in the step the four stages of classical Runge-Kutta look

Lines = Iterator[str]


def advance_source(s: Structure, width: int) -> str:
    """Return the source of `advance(lanes, excitation, count)`, which makes `count` steps of a block of `width` lanes.

    `lanes` is flat, row by row as in `s.row`; `excitation` is flat too, 2·count + 1 half steps of the columns
    EXCITATION for each mesh. Decorator and imports are left to the caller.
    """
    columns = len(EXCITATION) * s.meshes
    excitation = [
        f"{name}{j}_{half} = excitation[at + {half * columns + len(EXCITATION) * j + n}]"
        for half in range(3)
        for j in range(s.meshes)
        for n, name in enumerate(EXCITATION)
    ]
    body = [f"at = step * {2 * columns}", *excitation]
    for loop in (_forces(s), _motion(s)):
        body += [f"for lane in range({width}):", *(f"    {line}" for line in loop)]
    rows = [f"{name} = {index * width}" for name, index in s.row.items()]
    head = ["", "", "def advance(lanes, excitation, count):", "    for step in range(count):"]
    return "\n".join([*rows, *head, *(f"        {line}" for line in body), ""])


def _row(name: str) -> str:
    return f"lanes[{name.upper()} + lane]"


def _carried(s: Structure, mesh: int) -> tuple[str, ...]:
    """Return the prefixes of what is integrated of `mesh`: "" for the state, "z" for its tangent if there is one.

    Lines of state and tangent alternate, because they share their coefficients: one load serves both.
    """
    return ("", "z") if mesh < s.tangent_meshes else ("",)


def _forces(s: Structure) -> Lines:
    """First loop: sums over the state, then stage by stage each mesh's δ, its rate and its force, and the shaft."""
    for j in range(s.meshes):
        yield from _sums(s, j)
    for stage in STAGES:
        for j in range(s.meshes):
            yield from _closing(s, j, stage)
            yield from _force(s, j, stage)
        yield from chain.from_iterable(_end(s, i, far, stage) for i, far in s.ends)
        if stage < 4:
            yield from chain.from_iterable(_pushed(s, j, stage) for j in range(s.meshes))
            yield from chain.from_iterable(_next(s, i, stage) for i, _ in s.ends)
    yield from chain.from_iterable(_arrived(s, i) for i, _ in s.ends)
    if s.statistics:
        yield from chain.from_iterable(_statistics(j) for j in range(s.meshes))


def _sums(s: Structure, j: int) -> Lines:
    """What the state adds to δ and its rate of a mesh, and without forces to its closing accelerations."""
    yield from (f"a{stage}_{j} = {_row(f'a{stage}_{j}_drive')}" for stage in (1, 2, 3))
    terms, end = {f"a{stage}_{j}" for stage in (1, 2, 3)}, s.end(j)
    for i in s.mapped(j):
        for x in "qv":
            yield from (f"{z}{x}{i} = {_row(f'{z}{x}{i}')}" for z in _carried(s, j))
            yield from (_add(terms, f"{z}{x}_{j}", f"{z}{x}{i}") for z in _carried(s, j))
            for target in (f"a{stage}_{j}" for stage in (1, 2, 3)):
                for z in _carried(s, j):
                    yield _add(terms, f"{z}{target}", f"{_row(f'{target}_of_{x}{i}')} * {z}{x}{i}")
    if end is not None:
        for x in "qv":
            yield from (f"{z}{x}1_{end} = {_row(f'{z}{x}{end}')}" for z in _carried(s, j))
            yield from (_add(terms, f"{z}{x}_{j}", f"{z}{x}1_{end}") for z in _carried(s, j))


def _add(terms: set[str], name: str, term: str) -> str:
    """Return the line that adds `term` to `name`, or that begins `name` with it."""
    if name in terms:
        return f"{name} = {name} + {term}"
    terms.add(name)
    return f"{name} = {term}"


def _closing(s: Structure, j: int, stage: int) -> Lines:
    """δ of mesh j and its rate at a stage: d1_0, r1_0, …; the tangent has no excitation."""
    half = _HALF_STEP[stage]
    for z in _carried(s, j):
        q, v, a1, a2, a3 = (f"{z}{name}_{j}" for name in ("q", "v", "a1", "a2", "a3"))
        error, slope = ("", "") if z else (f" - error{j}_{half}", f" - slope{j}_{half}")
        delta = {
            1: f"{q}{error}",
            2: f"({q} + {v}){error}",
            3: f"{z}d2_{j} + {a1}",
            4: f"(({q} + {v}) + {v}{error}) + 2.0 * {a2}",
        }
        rate = {1: "", 2: f" + {a1}", 3: f" + {a2}", 4: f" + 2.0 * {a3}"}
        yield f"{z}d{stage}_{j} = {delta[stage]}"
        yield f"{z}r{stage}_{j} = {v}{slope}{rate[stage]}"


def _force(s: Structure, j: int, stage: int) -> Lines:
    """κ·f(δ) + c·δ′ without branches, and its derivative along the tangent; then into the scratch rows."""
    kappa, end = f"kappa{j}_{_HALF_STEP[stage]}", f"{stage}_{j}"
    damping = _row(s.damping(j, stage))
    yield f"free{end} = min(max(d{end}, {_row(f'lower{j}')}), {_row(f'upper{j}')})"
    yield f"beyond{end} = d{end} - free{end}"
    if s.damping_in_contact_only:
        yield f"c{end} = {damping} if beyond{end} != 0.0 else 0.0"
        damping = f"c{end}"
    yield f"f{end} = {kappa} * beyond{end} + {damping} * r{end}"
    prefixes = _carried(s, j)
    if "z" in prefixes:
        yield f"bent{end} = {kappa} if beyond{end} != 0.0 else 0.0"
        yield f"zf{end} = bent{end} * zd{end} + {damping} * zr{end}"
    if not s.backlash_in_torsion:
        yield f"u{end} = f{end} + {kappa} * free{end}"
        if "z" in prefixes:
            yield f"zu{end} = {kappa} * zd{end} + {damping} * zr{end}"
    for kind in "f" if s.backlash_in_torsion else "fu":
        yield from (f"{_row(f'{z}{kind}{j}_{stage}')} = {z}{kind}{end}" for z in prefixes)


def _pushed(s: Structure, j: int, stage: int) -> Lines:
    """Complete the closing acceleration of mesh j at a stage by what the shaft and the forces so far add."""
    pushes = [(later, force) for force in s.forces_of(j) for later in range(stage)]
    if s.coupled:
        yield from (f"{z}a{stage}_{j} = {z}a{stage}_{j} + {z}held{stage}_{s.end(j)}" for z in _carried(s, j))
        pushes.sort(reverse=True)  # the stage's own force is the last to be known
    for later, force in pushes:
        for z in _carried(s, j):
            name = f"{z}{force[0].lower()}{stage - later}_{j}"
            yield f"{z}a{stage}_{j} = {z}a{stage}_{j} + {_row(f'p{later}_{j}_{force}')} * {name}"


def _end(s: Structure, i: int, far: int, stage: int) -> Lines:
    """Acceleration of an end of the shaft at a stage: held1_3, … without the force of the mesh, e1_3, … with it."""
    force, terms = s.force_on(i), set[str]()
    for x in "qv":
        for m in (i, far):
            for z in _carried(s, i // PER_MESH):
                yield _add(terms, f"{z}held{stage}_{i}", f"{_row(f'e{i}_of_{x}{m}')} * {z}{x}{stage}_{m}")
    for z in _carried(s, i // PER_MESH):
        name = f"{z}{force[0].lower()}{stage}_{force[1]}"
        yield f"{z}e{stage}_{i} = {z}held{stage}_{i} + {_row(f'e{i}_of_{force}')} * {name}"


def _next(s: Structure, i: int, stage: int) -> Lines:
    """Where an end of the shaft is at the next stage, q2_3, …, and its change, v2_3, …"""
    for z in _carried(s, i // PER_MESH):
        twice = stage == 3
        change, gain = f"{z}v{stage}_{i}", f"{z}e{stage}_{i}"
        yield f"{z}q{stage + 1}_{i} = {z}q1_{i} + " + (f"({change} + {change})" if twice else change)
        yield f"{z}v{stage + 1}_{i} = {z}v1_{i} + " + (f"({gain} + {gain})" if twice else gain)
        if stage > 1:
            yield f"{z}so_far{i} = " + (f"{z}e1_{i}" if stage == 2 else f"{z}so_far{i}") + f" + {gain}"
        if stage == 3:
            yield f"{_row(f'{z}q{i}')} = ({z}q1_{i} + {z}v1_{i}) + ({z}v1_{i} + {2 / 3} * {z}so_far{i})"
            yield f"{z}nearly{i} = {z}v1_{i} + {1 / 3} * (({z}so_far{i} + {z}so_far{i}) - {z}e1_{i})"


def _arrived(s: Structure, i: int) -> Lines:
    """The step of an end of the shaft."""
    for z in _carried(s, i // PER_MESH):
        yield f"{_row(f'{z}v{i}')} = {z}nearly{i} + {1 / 3} * {z}e4_{i}"


def _statistics(j: int) -> Lines:
    """Count the step's start, where the force is that of stage 1."""
    force = f"f1_{j}"
    yield f"{_row(f'sum{j}')} = {_row(f'sum{j}')} + {force}"
    yield f"{_row(f'squares{j}')} = {_row(f'squares{j}')} + {force} * {force}"
    yield f"{_row(f'least{j}')} = min({_row(f'least{j}')}, {force})"
    yield f"{_row(f'most{j}')} = max({_row(f'most{j}')}, {force})"
    yield f"{_row(f'apart{j}')} = {_row(f'apart{j}')} + (0.0 if beyond1_{j} != 0.0 else 1.0)"


def _motion(s: Structure) -> Lines:
    """Second loop: the step of every coordinate, but the shaft's ends, from state and forces of the four stages."""
    for force in s.forces:
        for z in _carried(s, int(force[1])):
            name = f"{z}{force.lower()}"
            yield from (f"{name}_{stage} = {_row(f'{name}_{stage}')}" for stage in STAGES)
            yield f"{name}_4 = 0.5 * {name}_4"
    for i in chain.from_iterable(s.mapped(j) for j in range(s.meshes)):
        yield from _read(s, i)
        yield from _gain(s, i)
        yield from _write(s, i)


def _read(s: Structure, i: int) -> Lines:
    for z in _carried(s, i // PER_MESH):
        yield from (f"{z}{x}{i} = {_row(f'{z}{x}{i}')}" for x in "qv")


def _gain(s: Structure, i: int) -> Lines:
    """What coordinate i and its change gain in a step: dq and dv.

    A force of stage n + 1 gives v what one of stage n gives q, but of stage 4 half of what one of stage 3 gives.
    """
    prefixes, terms, force = _carried(s, i // PER_MESH), set[str](), s.force_on(i).lower()
    for to in "qv":
        if s.is_driven(i):
            yield _add(terms, f"d{to}{i}", _row(f"{to}{i}_drive"))
        for x in "qv":
            for z in prefixes:
                yield _add(terms, f"{z}d{to}{i}", f"{_row(f'{to}{i}_of_{x}{i}')} * {z}{x}{i}")
    for z in prefixes:
        yield _add(terms, f"{z}dv{i}", f"{_row(f'v{i}_first_{force}')} * {z}{force}_1")
    for n in (1, 2, 3):
        response = _row(f"r{n}_{i}_{force}")
        for z in prefixes:
            yield _add(terms, f"{z}dq{i}", f"{response} * {z}{force}_{n}")
            yield _add(terms, f"{z}dv{i}", f"{response} * {z}{force}_{n + 1}")


def _write(s: Structure, i: int) -> Lines:
    for z in _carried(s, i // PER_MESH):
        yield f"{_row(f'{z}q{i}')} = ({z}q{i} + {z}v{i}) + ({z}v{i} + {z}dq{i})"
        yield f"{_row(f'{z}v{i}')} = {z}v{i} + {z}dv{i}"
