#include "config/problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "text/visible.h"

namespace config {

std::string to_string(const Problem& problem) {
  std::string out = problem.where.file;
  if (problem.where.line != 0) {
    out += fmt::format(":{}:{}", problem.where.line, problem.where.column);
  }
  if (!out.empty()) out += ": ";
  if (!problem.key.empty()) out += problem.key + ": ";
  return text::visible(out + problem.text, "\n\t");
}

std::string problems_text(const std::vector<Problem>& problems) {
  constexpr std::size_t kLongList = 100;  // characters of what is allowed that are told once
  std::set<std::string> told;
  std::string out;
  for (std::size_t i = 0; i < std::min(problems.size(), kProblemsShown); ++i) {
    std::string text = to_string(problems[i]);
    const std::size_t allowed = text.find("; allowed");
    if (allowed != std::string::npos && text.size() - allowed > kLongList &&
        !told.insert(text.substr(allowed)).second)
      text = text.substr(0, allowed) + "; allowed: as above";
    out += text + "\n";
  }
  if (problems.size() > kProblemsShown) {
    out += "and " + std::to_string(problems.size() - kProblemsShown) + " more problems\n";
  }
  return out;
}

std::string problems_message(const std::vector<Problem>& problems) {
  std::string text = problems_text(problems);
  if (!text.empty()) text.pop_back();
  return text;
}

void sort_by_place(std::vector<Problem>& problems) {
  std::stable_sort(problems.begin(), problems.end(), [](const Problem& a, const Problem& b) {
    return std::tie(a.where.line, a.where.column) < std::tie(b.where.line, b.where.column);
  });
}

}  // namespace config
