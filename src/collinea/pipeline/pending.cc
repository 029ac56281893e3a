// SPDX-License-Identifier: Apache-2.0
#include "collinea/pipeline/step.h"
#include "collinea/pipeline/assess.h"
namespace collinea {
Result<StepOutput> report_step(Project&, const std::string&) { return fail(Errc::kUnsupported, "x"); }
Result<std::string> assess_project(const Project&, const std::filesystem::path&, bool) { return fail(Errc::kUnsupported, "x"); }
}
