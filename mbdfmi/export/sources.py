"""Sources of an FMU: the scene's own code, the wrapper, and what build tools need to know of them.

    scene.c                 all that the scene needs of the kernels (`core`)
    scene.h                 the same to be used without FMI: sizes, start values, places of variables, four functions
    table.c, layout.h       what the wrapper knows of the scene
    buildDescription.xml    FMI 3; in FMI 2 the model description lists the files
    CMakeLists.txt          a shared library of it, as it lies in binaries/

The headers of FMI are not among them: whoever builds an FMU has them (FMI 2.0.4, 2.3; FMI 3.0.2, 2.5.1).
"""

import re

from lxml import etree

from ..native.library import TABLE
from ..trace.forms import identifiers
from ..trace.program.types import constant
from . import header, standard
from .core import core
from .link import OTHERS, wrapper_folder, wrapper_sources

FOLDER = "sources"

_CMAKE = """# Written by mbdfmi: a shared library of the sources of this FMU.
#
#   cmake -S . -B build -DFMI_HEADERS=<folder of {header}> && cmake --build build
cmake_minimum_required(VERSION 3.15)
project({identifier} C)

set(FMI_HEADERS "" CACHE PATH "The folder of the headers of FMI ({header})")
set(CMAKE_C_STANDARD 99)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_C_VISIBILITY_PRESET hidden)

if(NOT CMAKE_BUILD_TYPE)
    set(CMAKE_BUILD_TYPE Release)
endif()

add_library({identifier} SHARED
{files})
target_include_directories({identifier} PRIVATE ${{CMAKE_CURRENT_SOURCE_DIR}} ${{FMI_HEADERS}})
set_target_properties({identifier} PROPERTIES PREFIX "")

if(MSVC)
    target_compile_options({identifier} PRIVATE /fp:precise)
else()
    target_compile_options({identifier} PRIVATE -ffp-contract=off -fno-math-errno)
    target_link_libraries({identifier} PRIVATE m)
endif()
"""


def sources(model, fmi: int, traced) -> dict[str, bytes]:
    """Path in the FMU -> its bytes. traced : kernels that are. Raises Untraceable."""
    headers = (path for path in sorted(wrapper_folder().glob("*.h")) if not path.name.startswith(OTHERS[fmi]))
    wrapper = [*wrapper_sources(fmi), *headers]
    texts = {path.name: path.read_text(encoding="utf-8") for path in wrapper}
    own = own_names(model, *(text for name, text in texts.items() if name.endswith(".h")))
    texts |= {
        header.NAME: header.layout_header(own),
        "table.c": f"{own}\n{header.table_of_kernels(header.entry.ENTRIES, model.guid)}",
        "scene.c": f"{own}\n{core(model, traced)}",
        "scene.h": scene_header(model),
    }
    files = compiled(fmi)
    listed = "".join(f"    {name}\n" for name in files).rstrip("\n")
    texts["CMakeLists.txt"] = _CMAKE.format(
        identifier=model.identifier, files=listed, header=f"fmi{fmi}Functions.h"
    )
    found = {f"{FOLDER}/{name}": text.encode() for name, text in texts.items()}

    if fmi == 3:
        found[f"{FOLDER}/buildDescription.xml"] = _build_description(model, files)

    return found


def own_names(model, *texts: str) -> str:
    """Names of what these texts of headers share among files as the model's own: several FMUs go into one program."""
    stems = "|".join(sorted({path.stem for path in wrapper_folder().glob("*.h")}))
    shared = set(re.findall(rf"\b(?:{stems})_\w+(?=\()", "\n".join(texts)))
    shared |= {*header.entry.ENTRIES, TABLE, "mbdfmi_only_guid"}
    lines = [f"#define {name} {model.identifier}_{name}" for name in sorted(shared)]
    return "\n".join(["/* several FMUs go into one program */", *lines, ""])


def compiled(fmi: int) -> list[str]:
    """Names of the files that are compiled, which the model description of FMI 2 lists."""
    return sorted(["scene.c", "table.c", *(path.name for path in wrapper_sources(fmi))])


def _build_description(model, files):
    """buildDescription.xml of FMI 3, checked against its schema."""
    root = etree.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = etree.SubElement(root, "BuildConfiguration", modelIdentifier=model.identifier)
    listed = etree.SubElement(
        configuration, "SourceFileSet", language="C99", compilerOptions="-ffp-contract=off"
    )

    for name in files:
        etree.SubElement(listed, "SourceFile", name=name)

    etree.SubElement(configuration, "Library", name="m")
    schema = standard.schema(3, "fmi3BuildDescription")
    schema.assertValid(root)
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def scene_header(model) -> str:
    """scene.h: the scene without FMI, for whoever has neither files nor an operating system."""
    n_u = model.n_u
    sizes = {
        "N_REALS": len(model.reals),
        "N_STATE": model.n_state,
        "N_WORK": model.n_work,
        "N_INPUTS": n_u,
        "N_U": n_u * header.N_DERIVATIVE,
        "N_Y": model.n_y,
    }
    lines = [f"#define SCENE_{name} {count}" for name, count in sizes.items()]
    enums = []

    for causality, array in (("parameter", "reals"), ("input", "u"), ("output", "y")):
        variables = sorted(model.of_causality(causality), key=lambda v: v.index)
        names = identifiers([v.name for v in variables], set())
        rows = "".join(
            f"    {causality.upper()}_{name} = {v.index},{f' /* {v.unit} */' if v.unit else ''}\n"
            for name, v in zip(names, variables)
        )

        if rows:
            enums.append(f"/* {causality}s: where they stand in `{array}` */\nenum {{\n{rows}}};")

    prototypes = "\n".join(f"{header.prototype(name)};" for name in header.entry.ENTRIES)
    calls = "\n\n".join(_CALL.format(**call) for call in _CALLS)
    return _HEADER.format(
        name=model.name,
        own=own_names(model),
        sizes="\n".join(lines),
        enums="\n\n".join(enums),
        prototypes=prototypes,
        reals=_numbers(model.reals),
        inputs=_numbers([v.start for v in sorted(model.of_causality("input"), key=lambda v: v.index)]),
        calls=calls,
    )


def _numbers(values):
    texts = [constant(float(value)) for value in values] or ["0.0"]
    rows = [", ".join(texts[k : k + 6]) for k in range(0, len(texts), 6)]
    return ",\n".join(f"    {row}" for row in rows)


_CALLS = (
    {"what": "Parameters or start values have changed", "name": "prepare", "more": "", "given": ""},
    {"what": "To the start at t (s)", "name": "initialise", "more": ", double t", "given": ", t"},
    {"what": "Onward by H (s)", "name": "step", "more": ", double H", "given": ", H"},
    {"what": "Outputs into y", "name": "outputs", "more": "", "given": ", scene->y"},
)

_CALL = """/* {what}. Returns 0, or what is wrong: a code, and 256 times the place. */
static inline int64_t scene_{name}(Scene *scene{more})
{{
    int64_t status = 0;
    void *unused = 0;

    mbdfmi_{name}(&status, &unused, 0, scene->reals, 0, scene->state, scene->work, scene->u{given});
    return status;
}}"""

_HEADER = """/* {name} without FMI: for processors without files. Written by mbdfmi.

   A Scene is all the memory that there is; nothing is allocated. Units are SI, angles in rad.

       static Scene scene;
       scene_reset(&scene);
       scene.reals[PARAMETER_...] = ...;
       status = scene_prepare(&scene);
       if (status == 0) status = scene_initialise(&scene, 0.0);
       for (;;) {{
           scene.u[INPUT_...] = ...;
           status = scene_step(&scene, 1e-3);
           status = scene_outputs(&scene);
           ... = scene.y[OUTPUT_...];
       }}
*/
#ifndef MBDFMI_SCENE_H
#define MBDFMI_SCENE_H

#include <stdint.h>
#include <string.h>

{own}
{sizes}

{enums}

typedef struct {{
    double reals[SCENE_N_REALS + 1], state[SCENE_N_STATE + 1], work[SCENE_N_WORK + 1];
    double u[SCENE_N_U + 1], y[SCENE_N_Y + 1];
}} Scene;

{prototypes}

/* Parameters and inputs as the scene gives them, all else nothing. */
static inline void scene_reset(Scene *scene)
{{
    static const double reals[] = {{
{reals}
    }};
    static const double inputs[] = {{
{inputs}
    }};

    memset(scene, 0, sizeof *scene);
    memcpy(scene->reals, reals, SCENE_N_REALS * sizeof(double));
    memcpy(scene->u, inputs, SCENE_N_INPUTS * sizeof(double));
}}

{calls}

#endif
"""
