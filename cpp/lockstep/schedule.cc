// List scheduling: of the rows whose bodies are ready, the one with most work behind it goes first.
#include "lockstep/schedule.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace itarl::lockstep {

namespace {

// Cycles from reading a row's velocities to having the new ones, and cycles of arithmetic that a
// row keeps from others; about right for current x86 processors, and not critical.
struct Cost {
  int latency, work;
};
Cost cost_in_lanes(const Touch& row) {
  switch (row.kind) {
    case Kind::AngularFree:
      return {36, 14};
    case Kind::Angular:  // mostly one of a run acts
      return {46 + 12 * int(row.count - 1), 17 + 8 * int(row.count - 1)};
    case Kind::FullFree:
      return {40 * int(row.count), 26 * int(row.count)};
    case Kind::Full:
      return {50, 29};
    case Kind::Contact:
    case Kind::Friction:
      return {48, 20};
    default:
      return {54, 32};
  }
}

// In one world alone (alone.inc). Of its hub's rows, runs mostly don't act, and what doesn't act isn't
// waited for.
Cost cost_alone(const Touch& row, bool of_hub) {
  const int work = 18 + (row.kind == Kind::Angular ? 4 * int(row.count - 1) : 0);
  if (!of_hub) return {42, work};
  return {row.kind == Kind::Angular ? 20 : row.kind == Kind::AngularFree ? 30 : 37, work};
}

// The body that is most rows' first.
std::uint32_t hub_of(const std::vector<Touch>& rows) {
  std::map<std::uint32_t, int> count;
  for (const Touch& row : rows) ++count[row.a];
  const auto less = [](const auto& one, const auto& other) { return one.second < other.second; };
  return count.empty() ? kNoBody : std::max_element(count.begin(), count.end(), less)->first;
}

std::vector<Cost> costs_of(const std::vector<Touch>& rows, bool alone) {
  const std::uint32_t hub = hub_of(rows);
  std::vector<Cost> costs;
  for (const Touch& row : rows) {
    costs.push_back(alone ? cost_alone(row, row.a == hub) : cost_in_lanes(row));
  }
  return costs;
}

// For each row, the next row that touches its body a, and the next that touches its body b.
struct Followers {
  std::vector<std::uint32_t> after_a, after_b;
};

Followers followers_of(const std::vector<Touch>& rows, std::uint32_t bodies) {
  const std::size_t n = rows.size();
  Followers next{std::vector<std::uint32_t>(n, kNoBody), std::vector<std::uint32_t>(n, kNoBody)};
  std::vector<std::uint32_t> first(bodies, kNoBody);
  for (std::size_t i = n; i-- > 0;) {
    if (rows[i].a != kNoBody) next.after_a[i] = first[rows[i].a];
    if (rows[i].b != kNoBody) next.after_b[i] = first[rows[i].b];
    if (rows[i].a != kNoBody) first[rows[i].a] = std::uint32_t(i);
    if (rows[i].b != kNoBody) first[rows[i].b] = std::uint32_t(i);
  }
  return next;
}

// For each row, the longest wait from its beginning to the end of the sweep.
std::vector<int> longest_waits(const std::vector<Cost>& costs, const Followers& next) {
  std::vector<int> wait(costs.size(), 0);
  for (std::size_t i = costs.size(); i-- > 0;) {
    for (const std::uint32_t follower : {next.after_a[i], next.after_b[i]}) {
      if (follower != kNoBody) wait[i] = std::max(wait[i], wait[follower]);
    }
    wait[i] += costs[i].latency;
  }
  return wait;
}

std::uint32_t count_bodies(const std::vector<Touch>& rows) {
  std::uint32_t bodies = 0;
  for (const Touch& row : rows) {
    if (row.a != kNoBody) bodies = std::max(bodies, row.a + 1);
    if (row.b != kNoBody) bodies = std::max(bodies, row.b + 1);
  }
  return bodies;
}

}  // namespace

std::vector<std::uint32_t> schedule(const std::vector<Touch>& rows, bool alone) {
  const std::size_t n = rows.size();
  const std::uint32_t bodies = count_bodies(rows);
  const Followers next = followers_of(rows, bodies);
  const std::vector<Cost> costs = costs_of(rows, alone);
  const std::vector<int> wait = longest_waits(costs, next);

  std::vector<int> waits_for(n, 0);  // rows before it
  for (std::size_t i = 0; i < n; ++i) {
    for (const std::uint32_t follower : {next.after_a[i], next.after_b[i]}) {
      if (follower != kNoBody) ++waits_for[follower];
    }
  }
  std::vector<std::uint32_t> open;
  for (std::size_t i = 0; i < n; ++i) {
    if (waits_for[i] == 0) open.push_back(std::uint32_t(i));
  }

  std::vector<std::uint32_t> order;
  std::vector<int> ready(n, 0);
  int now = 0;
  while (!open.empty()) {
    const auto before = [&](std::uint32_t a, std::uint32_t b) {
      const int start_a = std::max(ready[a], now), start_b = std::max(ready[b], now);
      if (start_a != start_b) return start_a < start_b;
      if (wait[a] != wait[b]) return wait[a] > wait[b];
      return a < b;
    };
    const auto best = std::min_element(open.begin(), open.end(), before);
    const std::uint32_t row = *best;
    open.erase(best);
    order.push_back(row);
    const Cost cost = costs[row];
    const int start = std::max(ready[row], now);
    now = start + cost.work;
    for (const std::uint32_t follower : {next.after_a[row], next.after_b[row]}) {
      if (follower == kNoBody) continue;
      ready[follower] = std::max(ready[follower], start + cost.latency);
      if (--waits_for[follower] == 0) open.push_back(follower);
    }
  }
  if (!is_legal(rows, order)) {  // never, as the tests know; Bullet's own order always is
    order.resize(n);
    std::iota(order.begin(), order.end(), 0);
  }
  return order;
}

bool is_legal(const std::vector<Touch>& rows, const std::vector<std::uint32_t>& order) {
  if (order.size() != rows.size()) return false;
  // For each body, one more than the last row that touched it.
  std::vector<std::uint32_t> last(count_bodies(rows), 0);
  std::vector<bool> seen(rows.size(), false);
  for (const std::uint32_t i : order) {
    if (i >= rows.size() || seen[i]) return false;
    seen[i] = true;
    for (const std::uint32_t body : {rows[i].a, rows[i].b}) {
      if (body == kNoBody) continue;
      if (last[body] > i) return false;
      last[body] = i + 1;
    }
  }
  return true;
}

}  // namespace itarl::lockstep
