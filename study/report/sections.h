#pragma once

#include <map>
#include <string>

#include "study/report/page.h"

namespace lcpbench::report {

// The parts of the report behind its first screen, each an HTML section with its anchor.

/// #sets: a table and the pictures of every set, and the sweeps; the hard cases have a section of their own, and "" is
/// returned where there is nothing else.
std::string sets_section(const Summary& summary, const Figures& figures);
/// #claims: what each solver said against what was true.
std::string claims_section(const Summary& summary);
/// #times: what the parts of a time are, with their means.
std::string times_section(const Summary& summary);
/// #provenance: of every run in the store, and the solvers left out.
std::string provenance_section(const Summary& summary);
/// #definitions
std::string definitions_section();
/// #limits
std::string limits_section(const Summary& summary);

/// The picture of a set in a box that scrolls, or a line on why there is none.
std::string figure_html(const std::map<std::size_t, Figure>& figures, std::size_t set, const std::string& missing);

}  // namespace lcpbench::report
