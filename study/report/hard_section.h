#pragma once

#include <string>

#include "study/report/summary.h"

namespace lcpbench::report {

/// #hard: who solves which hard case, and along each dial where each solver breaks and how. "" for a store without
/// hard cases.
std::string hard_section(const Summary& summary);

/// The link to it for the page's navigation; "" for a store without hard cases.
std::string hard_navigation(const Summary& summary);

/// The hard cases as text, in lines of `width` characters: for each solver what became of them, and every false claim
/// by name. "" without any.
std::string hard_text(const Summary& summary, int width);

}  // namespace lcpbench::report
