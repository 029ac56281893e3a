// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/hypothesis_layout.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "collinea/adjust/block_motion.h"
#include "collinea/adjust/observation_kinds.h"

namespace collinea::bundle {
namespace {

constexpr std::size_t kRaysForGruen = 150000;  // 44 parameters are left out of larger blocks

// The images of the problem in the order flown; of each strip from the first to the last.
std::vector<std::vector<int>> sequence_of(const Problem& problem, const SystematicOptions& options) {
  std::map<ImageId, int> number;
  for (int i = 0; i < problem.poses; ++i) number[problem.images[static_cast<std::size_t>(i)].id] = i;
  std::vector<std::vector<int>> strips;
  for (const auto& strip : options.strips) {
    std::vector<std::pair<double, int>> order;
    for (const auto& [id, time] : strip)
      if (const auto its = number.find(id); its != number.end()) order.emplace_back(time, its->second);
    std::sort(order.begin(), order.end());
    std::vector<int>& images = strips.emplace_back();
    for (const auto& [time, image] : order) images.push_back(image);
  }
  return strips;
}

void find_velocities(HypothesisLayout& layout) {
  layout.out.velocity.assign(layout.problem.images.size(), Eigen::Vector3d::Zero());
  layout.timed = !layout.options.velocity_m_s.empty();
  for (std::size_t i = 0; layout.timed && i < layout.problem.images.size(); ++i)
    if (const auto its = layout.options.velocity_m_s.find(layout.problem.images[i].id);
        its != layout.options.velocity_m_s.end())
      layout.out.velocity[i] = its->second;
  for (const std::vector<int>& strip : layout.strips)
    for (std::size_t k = 0; !layout.timed && strip.size() > 1 && k < strip.size(); ++k) {
      const std::size_t before = k > 0 ? k - 1 : k, after = std::min(k + 1, strip.size() - 1);
      layout.out.velocity[static_cast<std::size_t>(strip[k])] =
          (centre_in(layout.out.state, static_cast<std::size_t>(strip[after])) -
           centre_in(layout.out.state, static_cast<std::size_t>(strip[before]))) /
          static_cast<double>(after - before);
    }
}

}  // namespace

std::vector<int> range(int first, int count) {
  std::vector<int> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), first);
  return all;
}

HypothesisLayout::HypothesisLayout(const Solved& solved, const SystematicOptions& asked, HypothesisColumns& columns)
    : block(solved.block()),
      problem(solved.problem()),
      options(asked),
      out(columns),
      strips(sequence_of(problem, options)) {
  out.positions.resize(problem.positions.size());
  out.attitudes.resize(problem.attitudes.size());
  find_velocities(*this);
}

Hypothesis& HypothesisLayout::add(SystematicKind kind, const char* unit, const char* effect_unit,
                                  std::vector<int> columns) {
  Hypothesis& made = out.hypotheses.emplace_back();
  made.test.kind = kind;
  made.test.unit = unit;
  made.test.effect_unit = effect_unit;
  made.columns = std::move(columns);
  return made;
}

void add_hypothesis_of_bowl(HypothesisLayout& layout) {
  std::vector<Eigen::Vector2d> given;
  for (const GivenPosition& one : layout.problem.positions)
    if (one.inverse_sigma.z() > 0) given.push_back(centre_in(layout.out.state, one.image).head<2>());
  ControlCoordinate::for_each(layout.problem, [&](std::size_t p) {
    if (ControlCoordinate::inverse_sigma(layout.problem, p).z() > 0)
      given.push_back(Eigen::Map<const Eigen::Vector2d>(&layout.out.state.points[3 * p]));
  });
  if (given.size() < 4) return;
  for (const Eigen::Vector2d& one : given) layout.out.bowl_middle += one / static_cast<double>(given.size());
  layout.out.bowl_radius_m = 0;
  for (const Eigen::Vector2d& one : given)
    layout.out.bowl_radius_m = std::max(layout.out.bowl_radius_m, (one - layout.out.bowl_middle).norm());
  if (!(layout.out.bowl_radius_m > 0)) return;
  layout.out.has_bowl = true;
  for (std::size_t i = 0; i < layout.problem.positions.size(); ++i)
    layout.out.positions[i][2].push_back(
        {layout.out.bowl(), layout.out.bowl_at(centre_in(layout.out.state, layout.problem.positions[i].image))});
  layout.add(SystematicKind::kBowl, "m", "m", {layout.out.bowl()});
}

HypothesisColumns lay_out_hypotheses(const Solved& solved, const SystematicOptions& options) {
  const bool with_gruen = solved.problem().rays.size() <= kRaysForGruen;
  HypothesisColumns columns(solved.problem(), solved.state(), with_gruen);
  HypothesisLayout layout(solved, options, columns);
  add_hypotheses_of_instruments(layout);
  columns.first_image_column = layout.next;
  add_hypotheses_of_images(layout);
  add_hypothesis_of_bowl(layout);
  return columns;
}

}  // namespace collinea::bundle
