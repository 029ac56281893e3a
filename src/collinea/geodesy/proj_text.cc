// SPDX-License-Identifier: Apache-2.0
#include "collinea/geodesy/proj_text.h"

#include <proj.h>

#include "collinea/geodesy/internal/map_projection.h"

namespace collinea {

std::optional<std::string> proj_text(const LocalFrame& frame) {
  const ProjContext context = quiet_proj_context();
  ProjObject crs(proj_create(context.get(), frame.wkt2().c_str()));
  while (crs) {
    const PJ_TYPE type = proj_get_type(crs.get());
    if (type == PJ_TYPE_COMPOUND_CRS)
      crs.reset(proj_crs_get_sub_crs(context.get(), crs.get(), 0));
    else if (type == PJ_TYPE_BOUND_CRS)
      crs.reset(proj_get_source_crs(context.get(), crs.get()));
    else
      break;
  }
  const char* written = crs ? proj_as_proj_string(context.get(), crs.get(), PJ_PROJ_4, nullptr) : nullptr;
  if (!written) return std::nullopt;
  std::string text = written;
  if (const auto type = text.find(" +type=crs"); type != std::string::npos) text.erase(type, 10);
  return text;
}

}  // namespace collinea
