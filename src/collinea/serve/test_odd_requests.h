// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace collinea::testing {

/// Requests that are nearly right, and such that are not.
class OddRequests {
 public:
  OddRequests(std::string host, std::string cookie, std::string project)
      : host_(std::move(host)), cookie_(std::move(cookie)), project_(std::move(project)) {}

  std::string next() {
    if (below(10) == 0) return bytes(below(400));
    std::string text = below(3) != 0 ? "GET" : one({"HEAD", "POST", "PUT", "OPTIONS", "get", "", "CONNECT", "PRI"});
    text += " " + target();
    text += " " + (below(4) != 0 ? "HTTP/1.1" : one({"HTTP/1.0", "HTTP/2.0", "HTTP/9", ""}));
    text += "\r\n";
    if (below(8) != 0) text += "Host: " + host_ + "\r\n";
    if (below(8) != 0) text += "Cookie: " + cookie_ + "\r\n";
    for (int i = below(4); i > 0; --i) text += header() + "\r\n";
    text += "\r\n";
    if (below(2) == 0)
      text += one({"{\"step\": \"detect\"}", "{\"step\":", "[[[[[[", "5\r\nhello\r\n0\r\n\r\n"}) + bytes(below(50));
    if (below(3) == 0)
      for (int i = 1 + below(5); i > 0; --i)
        text[static_cast<std::size_t>(below(static_cast<int>(text.size())))] = byte();
    if (below(6) == 0) text.resize(static_cast<std::size_t>(below(static_cast<int>(text.size()))));
    return text;
  }

 private:
  int below(int bound) { return static_cast<int>(random_() % static_cast<unsigned>(std::max(1, bound))); }
  char byte() { return static_cast<char>(below(256)); }
  std::string bytes(int count) {
    std::string text;
    while (count-- > 0) text += byte();
    return text;
  }
  std::string one(std::vector<std::string> choices) {
    return choices[static_cast<std::size_t>(below(static_cast<int>(choices.size())))];
  }
  std::string target() {
    std::string text =
        one({"/", "/page.js", "/api/projects", "/api/options", "/api/jobs", "/api/jobs/1/stop", "/api/events", project_,
             project_ + "/jobs", project_ + "/settings", project_ + "/files/products/dsm.tif",
             project_ + "/files/products/secret", project_ + "/files/../../secret", "//", "*", "http://x/"});
    if (below(3) == 0)
      text += one({"?", "?token=0", "/..", "%2e%2e", "%", "%00", "#", "?since=99999999999999999999", "/"});
    return text;
  }
  std::string header() {
    return one({"Range: bytes=" + one({"0-1", "-1", "5-", "0-0,2-3", "9-1", "-", "18446744073709551616-", "x"}),
                "Content-Length: " + one({"0", "18", "-1", "99999999999999999999", "x", "70000"}),
                "Content-Type: application/json", "Transfer-Encoding: chunked", "Expect: 100-continue",
                "Connection: " + one({"close", "Upgrade", "keep-alive"}), "Upgrade: websocket",
                "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
                "Origin: " + one({"null", "http://" + host_, "http://evil.example"}), "If-Range: \"x\"",
                "X: " + bytes(below(300)), std::string(static_cast<std::size_t>(below(30'000)), 'h')});
  }

  std::mt19937 random_{20261127};
  std::string host_, cookie_, project_;
};

}  // namespace collinea::testing
