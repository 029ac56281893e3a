// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "collinea/app/flags.h"
#include "collinea/steps/step_list.h"

namespace collinea {

inline constexpr const char* kSeedHelp = "of everything random: same seed, same bits";

// One function a command, each in a file of its name (import beside run); a new one is declared here and listed below.
Command run_command();
Command import_command();
/// detect, match, orient, densify, surface, ortho, report: the same command for every step after import.
Command step_command(Step step, const std::string& summary);
Command info_command();
Command adjust_command();
Command export_command();
Command volume_command();
Command measure_command();
Command profile_command();
Command plan_command();
Command simulate_command();
Command assess_command();
Command pair_command();
Command stereo_command();
Command lines_command();
Command rectify_command();
Command relative_command();
Command triplet_command();
Command factorise_command();
Command interest_command();
Command correlate_command();
Command resection_command();
Command intersection_command();
Command monoplot_command();
Command plot_command();
Command absolute_command();
Command rotation_command();
Command collinearity_command();
Command refraction_command();
Command edges_command();
Command enhance_command();
Command models_command();
Command verify_command();
Command evaluate_command();
Command grid_command();
Command interior_command();
Command edit_command();
Command serve_command();
Command predict_command();
Command ground_command();
Command tags_command();
Command target_command();

/// Commands under one heading of the help.
struct CommandGroup {
  std::string heading;
  std::vector<Command> commands;
};

/// The only list of commands, in the order of the help. Each has a page of its name in docs/manual (commands_test.cc
/// sees to it); man pages and completion are made from both.
[[nodiscard]] inline std::vector<CommandGroup> command_groups() {
  return {
      {"Map: photographs to products",
       {
           run_command(),
           import_command(),
           step_command(Step::kDetect, "find features (SIFT, or corners of Harris or Foerstner) in every image"),
           step_command(Step::kMatch, "match features between images and verify them"),
           step_command(Step::kOrient, "find poses, cameras and tie points, with GNSS and control"),
           adjust_command(),
           step_command(Step::kDensify, "depth maps and fused point cloud"),
           step_command(Step::kSurface, "digital surface model (GeoTIFF)"),
           step_command(Step::kTerrain, "digital terrain model and contours (GeoTIFF, GeoPackage, DXF)"),
           step_command(Step::kOrtho, "orthophoto (Cloud-Optimised GeoTIFF)"),
           step_command(Step::kFrames, "surfaces, orthophotos and drawings of facades and other planes"),
           step_command(Step::kReport, "quality report (HTML and JSON)"),
           info_command(),
           edit_command(),
           verify_command(),
           serve_command(),
           predict_command(),
           ground_command(),
       }},
      {"Pair: two images",
       {
           pair_command(),
           stereo_command(),
           lines_command(),
       }},
      {"Single steps: one method, with its standard deviations",
       {
           relative_command(),     triplet_command(),  factorise_command(), interest_command(),
           correlate_command(),    absolute_command(), interior_command(),  resection_command(),
           intersection_command(), monoplot_command(), rotation_command(),  collinearity_command(),
           refraction_command(),   edges_command(),    target_command(),    tags_command(),
           enhance_command(),      models_command(),   rectify_command(),   measure_command(),
           plot_command(),         volume_command(),   profile_command(),   evaluate_command(),
           grid_command(),
       }},
      {"Planning",
       {
           plan_command(),
           simulate_command(),
           assess_command(),
       }},
      {"Exchange",
       {
           export_command(),
       }},
  };
}

/// Every command, each with the heading of its group.
[[nodiscard]] inline std::vector<Command> all_commands() {
  std::vector<Command> all;
  for (CommandGroup& group : command_groups())
    for (Command& command : group.commands) {
      command.group = group.heading;
      all.push_back(std::move(command));
    }
  return all;
}

}  // namespace collinea
