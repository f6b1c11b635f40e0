#pragma once
#include <array>
#include <string_view>

/// The works that docstrings, docs and errata cite by a code. Full entries, and those of works cited by name and year:
/// docs/references.bib, under the same keys. A code with an equation or section ("HF eq. 6") is the work as printed; what is
/// wrong there, and what stands here instead: docs/errata.md.
namespace klang {

struct Reference {
  std::string_view code;
  std::string_view key;  ///< in docs/references.bib
  std::string_view title;
};

inline constexpr std::array kReferences{
    Reference{"S02", "obrien2002", "Synthesizing sounds from rigid-body simulations"},
    Reference{"H03", "hauser2003", "Interactive deformation using modal analysis with constraints"},
    Reference{"B99", "obrien1999", "Graphical modeling and animation of brittle fracture"},
    Reference{"D02", "obrien2002ductile", "Graphical modeling and animation of ductile fracture"},
    Reference{"HF", "zheng2009", "Harmonic fluids"},
    Reference{"SB", "zheng2010", "Rigid-body fracture sound with precomputed soundbanks"},
};

}  // namespace klang
