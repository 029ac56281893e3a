// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/routes.h"

#include "collinea/project/settings_change.h"
#include "collinea/serve/control_routes.h"
#include "collinea/serve/drawing_routes.h"
#include "collinea/serve/edit_routes.h"
#include "collinea/serve/image_routes.h"
#include "collinea/serve/internal/byte_range.h"
#include "collinea/serve/internal/content_coding.h"
#include "collinea/serve/internal/json_answer.h"
#include "collinea/serve/internal/page.h"
#include "collinea/serve/internal/target.h"
#include "collinea/serve/options_json.h"
#include "collinea/serve/project_files.h"
#include "collinea/serve/project_json.h"
#include "collinea/serve/stereo_routes.h"

namespace collinea {
namespace {

// The cookie is not sent along when another site or a file led here, only when a page of this server goes on.
HttpResponse entered(std::string cookie) {
  HttpResponse response{
      .type = "text/html; charset=utf-8",
      .body =
          "<!doctype html><meta charset=\"utf-8\"><meta http-equiv=\"refresh\" content=\"0; url=/\">"
          "<link rel=\"icon\" href=\"/icon.svg\"><title>collinea</title><p><a href=\"/\">Go on</a></p>"};
  response.headers.emplace_back("Set-Cookie", std::move(cookie));
  return response;
}

HttpResponse file_response(const HttpRequest& request, const ServedProject& project,
                           std::span<const std::string> parts) {
  auto file = OpenFile::in_project(project.folder, parts);
  if (!file) return not_found();
  HttpResponse response{.type = std::string(content_type_of(parts.back()))};
  response.headers = {{"Accept-Ranges", "bytes"}, {"ETag", file->tag()}, {"Cache-Control", "no-cache"}};
  const std::string_view unless_changed = request.header("if-range");
  const bool whole = !unless_changed.empty() && unless_changed != file->tag();
  const ByteRange range = asked_range(whole ? "" : request.header("range"), file->size());
  const std::string size = std::to_string(file->size());
  if (range.kind == ByteRange::Kind::kUnsatisfiable) {
    response = error_answer(416, "the file has no such range, or several were asked for");
    response.headers.emplace_back("Content-Range", "bytes */" + size);
    return response;
  }
  FilePart part{file, 0, file->size()};
  if (range.kind == ByteRange::Kind::kPart) {
    part = {file, range.first, range.size};
    response.status = 206;
    response.headers.emplace_back("Content-Range", "bytes " + std::to_string(range.first) + "-" +
                                                       std::to_string(range.first + range.size - 1) + "/" + size);
  }
  response.file = std::move(part);
  return response;
}

HttpResponse new_job(const HttpRequest& request, const ServedProject& project, Site& site) {
  if (!request.header("content-type").starts_with("application/json"))
    return error_answer(415, "a job is described as application/json");
  Result<JobRequest> asked = [&]() -> Result<JobRequest> {
    COLLINEA_TRY(JobRequest job, job_request_in(request.body));
    COLLINEA_TRY(const Settings settings, read_settings(project.folder));
    COLLINEA_TRY([[maybe_unused]] const Settings changed, changed_settings(settings, job.options));
    job.project = project;
    return job;
  }();
  if (!asked) return error_answer(asked.error());
  const auto id = site.board.add(*std::move(asked));
  if (!id)
    return error_answer(503, std::to_string(JobBoard::kMostWaiting) + " jobs are waiting: stop some, or ask later");
  return json_answer(job_json(*id), 202);
}

HttpResponse settings_of(const ServedProject& project) {
  return answer_or_error(
      read_settings(project.folder).map([](const Settings& settings) { return settings_text(settings); }));
}

// Below /api/projects/ID.
HttpResponse project_response(const HttpRequest& request, const Target& target, Site& site) {
  const auto project = find_project(site.roots, target.path[2]);
  if (!project) return not_found();
  const std::string what = target.path.size() > 3 ? target.path[3] : "";
  const bool reads = request.method != "POST";
  if (target.path.size() == 3) return reads ? answer_or_error(project_json(*project)) : method_not_allowed("GET");
  if (what == "files") {
    if (!reads) return method_not_allowed("GET");
    return file_response(request, *project, std::span(target.path).subspan(4));
  }
  if (auto response = control_response(request, target, *project, *site.views)) return *std::move(response);
  if (auto response = stereo_response(request, target, *project, *site.views)) return *std::move(response);
  if (auto response = drawing_response(request, target, *project, *site.views)) return *std::move(response);
  if (what == "images")
    return reads ? image_response(request, *project, std::span(target.path).subspan(4), *site.views)
                 : method_not_allowed("GET");
  if (target.path.size() > 4) return not_found();
  if (what == "jobs") return reads ? method_not_allowed("POST") : new_job(request, *project, site);
  if (what == "edits") return edits_response(request, target, *project, *site.journals);
  if (what == "cloud") return reads ? cloud_response(*project, *site.journals) : method_not_allowed("GET");
  if (what == "settings") return reads ? settings_of(*project) : method_not_allowed("GET");
  return not_found();
}

HttpResponse stop_job(const std::string& id, JobBoard& board) {
  const auto number = number_of(id);
  return number && board.stop(*number) ? json_answer(std::string("{}")) : not_found();
}

HttpResponse api_response(const HttpRequest& request, const Target& target, Site& site) {
  const std::string what = target.path.size() > 1 ? target.path[1] : "";
  const bool reads = request.method != "POST";
  if (what == "projects" && target.path.size() > 2) return project_response(request, target, site);
  if (what == "jobs" && target.path.size() == 4 && target.path[3] == "stop")
    return reads ? method_not_allowed("POST") : stop_job(target.path[2], site.board);
  if (target.path.size() != 2) return not_found();
  if (what == "projects")
    return reads ? json_answer(projects_json(find_projects(site.roots))) : method_not_allowed("GET");
  if (what == "options") return reads ? json_answer(options_json()) : method_not_allowed("GET");
  if (what == "jobs") return reads ? json_answer(changes_json(site.board.since(0))) : method_not_allowed("GET");
  return not_found();
}

// What lies in assets/ has a name that changes with what it holds.
HttpResponse page_response(const HttpRequest& request, const Target& target) {
  std::string name;
  for (const std::string& part : target.path) name += (name.empty() ? "" : "/") + part;
  const std::optional<PageFile> file = page_file(name);
  if (!file) return not_found();
  if (request.method == "POST") return method_not_allowed("GET");
  const bool zipped = !file->zipped.empty() && allows_gzip(request.header("accept-encoding"));
  HttpResponse response{.type = std::string(file->type), .body = std::string(zipped ? file->zipped : file->bytes)};
  const bool never_changes = name.starts_with("assets/");
  response.headers = {{"Cache-Control", never_changes ? "private, max-age=31536000, immutable" : "no-cache"},
                      {"Vary", "Accept-Encoding"}};
  if (zipped) response.headers.emplace_back("Content-Encoding", "gzip");
  return response;
}

}  // namespace

HttpResponse answer(const HttpRequest& request, Site& site) {
  if (auto refused = site.access.foreign(request)) return *refused;
  const auto target = parsed_target(request.target);
  if (target && target->path.empty() && request.method == "GET") {
    const auto token = target->query.find("token");
    if (token != target->query.end())
      if (auto cookie = site.access.exchange(token->second)) {
        if (site.link_used) site.link_used();
        return entered(std::move(*cookie));
      }
  }
  if (auto refused = site.access.refusal(request)) return *refused;
  if (!target) return error_answer(400, "the address cannot be read");
  if (request.method != "GET" && request.method != "HEAD" && request.method != "POST")
    return method_not_allowed("GET, HEAD, POST");
  if (!target->path.empty() && target->path[0] == "api") return api_response(request, *target, site);
  return page_response(request, *target);
}

std::uint64_t asked_since(std::string_view target) {
  const auto parsed = parsed_target(target);
  if (!parsed) return 0;
  const auto since = parsed->query.find("since");
  return since == parsed->query.end() ? 0 : number_of(since->second).value_or(0);
}

std::vector<std::pair<std::string, std::string>> guarding_headers(bool is_project_file) {
  // Pages of a project are self-contained; a sandbox keeps them from asking the server anything.
  const std::string policy = is_project_file
                                 ? "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:"
                                 : "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; "
                                   "style-src 'self'; img-src 'self'; connect-src 'self'; "
                                   "frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
  return {{"Content-Security-Policy", policy},
          {"X-Content-Type-Options", "nosniff"},
          {"Referrer-Policy", "no-referrer"},
          {"Cross-Origin-Opener-Policy", "same-origin"},
          {"Cross-Origin-Resource-Policy", "same-origin"}};
}

}  // namespace collinea
