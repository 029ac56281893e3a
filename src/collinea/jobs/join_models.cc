// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/join_models.h"

#include <fmt/format.h>

#include <map>
#include <string>
#include <vector>

#include "collinea/base/file.h"
#include "collinea/base/nearest_names.h"
#include "collinea/io/text_table.h"
#include "collinea/jobs/adjust_project.h"
#include "collinea/jobs/internal/model_findings.h"
#include "collinea/models/concatenate.h"
#include "collinea/models/model_tables.h"
#include "collinea/project/project.h"
#include "collinea/report/findings_text.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

template <class Read>
auto from_table(const fs::path& file, Read&& read) -> decltype(read(TextTable{})) {
  COLLINEA_TRY(const TextTable table, read_text_table(file));
  return read(table).map_error([&](Error e) { return std::move(e).within(file.string()); });
}

Result<std::vector<std::pair<ImageId, ImageId>>> pairs_of(const Block& block, const TextTable& table) {
  COLLINEA_TRY(const auto left, table.words("left"));
  COLLINEA_TRY(const auto right, table.words("right"));
  std::map<std::string, ImageId> ids;
  std::vector<std::string> names;
  for (const auto& [id, image] : block.images) {
    ids[image.file] = id;
    names.push_back(image.file);
  }
  std::vector<std::pair<ImageId, ImageId>> pairs;
  for (std::size_t i = 0; i < left.size(); ++i) {
    for (const std::string& name : {left[i], right[i]})
      if (!ids.contains(name))
        return tl::unexpected(
            with_nearest(Error{Errc::kNotFound, fmt::format("{}: no such image", name), {}}, name, names));
    if (left[i] == right[i]) return fail(Errc::kBadInput, "an image makes no pair with itself: " + left[i]);
    pairs.emplace_back(ids[left[i]], ids[right[i]]);
  }
  return pairs;
}

// What models were formed from, for the bundle.
struct Source {
  Block block;
  ModelsOfBlock formed;
};

Result<> form_models(Source& source, const JoinModelsOptions& options, const Run& run, ModelsReport& report) {
  const Block& block = source.block;
  if (options.covariances || options.sigma)
    return fail(Errc::kBadInput, "models that are formed from images have the covariances of their orientation",
                {"covariances"_option, "sigma"_option});
  ModelPairChoice choice;
  choice.most_points = options.most_points;
  auto pairs = model_pairs(block, choice);
  if (options.pairs) {
    COLLINEA_TRY(pairs, from_table(*options.pairs, [&](const TextTable& table) { return pairs_of(block, table); }));
  }
  COLLINEA_TRY(source.formed, models_of_block(block, pairs, choice, true, run));
  report.models = source.formed.models;
  report.control = source.formed.control;
  report.pairs = source.formed.pairs;
  for (const FormedModel& pair : report.pairs)
    report.pair_names.push_back(block.images.at(pair.left).file + " + " + block.images.at(pair.right).file);
  report.model_unit = "";
  return {};
}

Result<> read_models(const fs::path& source, const JoinModelsOptions& options, ModelsReport& report) {
  if (options.pairs)
    return fail(Errc::kBadInput, "pairs of images are for an adjustment file or a project", {"pairs"_option});
  if (options.bundle)
    return fail(Errc::kBadInput, "models of a table have no image measurements: there is no bundle of them",
                {"bundle"_option});
  COLLINEA_TRY(GivenModels given,
               from_table(source, [&](const TextTable& table) { return models_of(table, options.sigma); }));
  if (options.covariances)
    COLLINEA_TRY(from_table(*options.covariances, [&](const TextTable& t) { return add_covariances(given, t); }));
  report.models = std::move(given.models);
  report.model_unit = given.unit;
  report.sigmas_known = given.sigmas_given;
  if (!given.sigmas_given) report.sigma_guessed = given.sigma;
  return {};
}

Result<> read_source(const fs::path& path, const JoinModelsOptions& options, const Run& run, Source& source,
                     ModelsReport& report) {
  if (fs::is_directory(path)) {
    COLLINEA_TRY(const Project project, open_project(path, run));
    COLLINEA_TRY(source.block, project.store.read_block());
    return form_models(source, options, run, report);
  }
  COLLINEA_TRY(const std::string text, read_file(path));
  if (!is_adjustment_file(text)) return read_models(path, options, report);
  COLLINEA_TRY(FileAdjustment given, read_adjustment(path));
  source.block = std::move(given.file.block);
  return form_models(source, options, run, report);
}

// Each model is levelled by its approximate orientation; the result is of the models as they were given.
void add_anblock(const Run& run, ModelsReport& report) {
  const ModelChain& chain = report.block.chain;
  std::vector<StereoModel> level = report.models;
  std::vector<bool> used;
  for (std::size_t m = 0; m < level.size(); ++m) {
    used.push_back(chain.ground_from_model[m].has_value());
    if (used.back()) level[m] = levelled(level[m], chain.ground_from_model[m]->rotation);
  }
  AnblockOptions how;
  how.sigmas_known = report.sigmas_known;
  how.most_cycles = 50;
  auto joined = anblock(level, used, report.control, how, run);
  if (!joined) {
    report.anblock_failure = joined.error().message;
    return;
  }
  for (std::size_t m = 0; m < level.size(); ++m)
    if (joined->models[m]) {
      Eigen::Quaterniond& rotation = joined->models[m]->ground_from_model.rotation;
      rotation = (rotation * chain.ground_from_model[m]->rotation).normalized();
    }
  report.anblock = *std::move(joined);
}

Result<> write_tables(const ModelsReport& report, const fs::path& folder) {
  COLLINEA_TRY(write_file(folder / "points.txt", text_of(joined_point_table(report))));
  COLLINEA_TRY(write_file(folder / "models.txt", text_of(joined_model_table(report))));
  COLLINEA_TRY(write_file(folder / "residuals.txt", text_of(model_residual_table(report))));
  COLLINEA_TRY(write_file(folder / "control.txt", text_of(joined_control_table(report))));
  COLLINEA_TRY(write_file(folder / "findings.json", findings_json_text(report.findings)));
  if (report.pairs.empty()) return {};
  COLLINEA_TRY(write_file(folder / "formed.txt", text_of(formed_model_table(report))));
  return write_file(folder / "covariances.txt", text_of(formed_covariance_table(report)));
}

Result<> join(const Source& measured, const JoinModelsOptions& options, const Run& run, ModelsReport& report) {
  if (options.chain_only) {
    if (options.anblock || options.bundle)
      return fail(Errc::kBadInput, "a chain is compared with nothing", {"anblock"_option, "bundle"_option});
    report.chain_only = true;
    COLLINEA_TRY(report.block, concatenate_models(report.models, report.control, report.sigmas_known));
    return {};
  }
  JoinOptions how;
  how.sigmas_known = report.sigmas_known;
  how.false_alarm = options.false_alarm;
  COLLINEA_TRY(report.block, join_models(report.models, report.control, how, run));
  if (options.anblock) add_anblock(run, report);
  if (options.bundle) {
    COLLINEA_TRY(report.bundle, bundle_of_models(measured.block, measured.formed, report.control, report.block,
                                                 report.sigmas_known, run)
                                    .map_error([](Error e) { return std::move(e).about("bundle"_option); }));
  }
  return {};
}

}  // namespace

Result<ModelsReport> join_models_of(const fs::path& source, const JoinModelsOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  ModelsReport report;
  Source measured;
  COLLINEA_TRY(read_source(source, options, run, measured, report));
  if (options.control) {
    COLLINEA_TRY(report.control, from_table(*options.control, [&](const TextTable& table) {
                   return surveyed_points_of(table, options.control_sigma_m);
                 }));
  }
  report.sigmas_known &= !options.estimate_sigma;
  report.false_alarm = options.false_alarm;
  COLLINEA_TRY(join(measured, options, run, report));
  report.findings = model_findings(report);
  if (options.out) COLLINEA_TRY(write_tables(report, *options.out));
  return report;
}

}  // namespace collinea
