// SPDX-License-Identifier: Apache-2.0
#include "vision/min_cut.hpp"

#include <algorithm>
#include <cassert>
#include <limits>

namespace choreo::vision {

MinCut::MinCut(int nodes)
    : nodes_(nodes),
      excess_(std::size_t(nodes), 0),
      parent_(std::size_t(nodes), kNone),
      tree_(std::size_t(nodes), kFree),
      waiting_(std::size_t(nodes), 0),
      distance_(std::size_t(nodes), 0),
      stamp_(std::size_t(nodes), 0) {}

void MinCut::add_cost(int node, int if_sink, int if_source) {
  assert(if_sink >= 0 && if_source >= 0);
  excess_[std::size_t(node)] += if_sink - if_source;
}

void MinCut::join(int a, int b, int weight) {
  assert(a != b && weight >= 0);
  if (weight > 0) joins_.push_back({a, b, weight});
}

void MinCut::build() {
  first_arc_.assign(std::size_t(nodes_) + 1, 0);
  for (const auto& j : joins_) {
    ++first_arc_[std::size_t(j.a) + 1];
    ++first_arc_[std::size_t(j.b) + 1];
  }
  for (std::size_t i = 1; i < first_arc_.size(); ++i) first_arc_[i] += first_arc_[i - 1];
  arcs_.resize(2 * joins_.size());
  auto next = first_arc_;
  for (const auto& j : joins_) {
    const int there = next[std::size_t(j.a)]++;
    const int back = next[std::size_t(j.b)]++;
    arcs_[std::size_t(there)] = {j.b, back, j.weight};
    arcs_[std::size_t(back)] = {j.a, there, j.weight};
  }
  joins_.clear();
}

void MinCut::wake(int node) {
  if (waiting_[std::size_t(node)] != 0) return;
  waiting_[std::size_t(node)] = 1;
  active_.push_back(node);
}

// What can still flow along an arc that leaves a node of `tree`, in the direction of that tree's flow.
int MinCut::residual_towards(int arc, Tree tree) const {
  const auto& a = arcs_[std::size_t(arc)];
  return tree == kSourceTree ? a.capacity : arcs_[std::size_t(a.twin)].capacity;
}

// An arc from the source's tree to the sink's, or kNone where no path is left.
int MinCut::grow() {
  for (; next_active_ < active_.size(); ++next_active_) {
    if (next_active_ > std::size_t(nodes_) && 2 * next_active_ > active_.size()) {
      active_.erase(active_.begin(), active_.begin() + std::ptrdiff_t(next_active_));
      next_active_ = 0;
    }
    const int node = active_[next_active_];
    const auto n = std::size_t(node);
    const auto tree = tree_[n];
    if (tree != kFree) {
      for (int arc = first_arc_[n]; arc < first_arc_[n + 1]; ++arc) {
        if (residual_towards(arc, tree) == 0) continue;
        const auto& a = arcs_[std::size_t(arc)];
        const auto to = std::size_t(a.to);
        if (tree_[to] == kFree) {
          tree_[to] = tree;
          parent_[to] = a.twin;
          stamp_[to] = stamp_[n];
          distance_[to] = distance_[n] + 1;
          wake(a.to);
        } else if (tree_[to] != tree) {
          return tree == kSourceTree ? arc : a.twin;
        } else if (stamp_[to] <= stamp_[n] && distance_[to] > distance_[n] + 1) {
          // A shorter way to the same terminal.
          parent_[to] = a.twin;
          stamp_[to] = stamp_[n];
          distance_[to] = distance_[n] + 1;
        }
      }
    }
    waiting_[n] = 0;
  }
  return kNone;
}

void MinCut::augment(int middle) {
  auto& bridge = arcs_[std::size_t(middle)];
  const int source_end = arcs_[std::size_t(bridge.twin)].to;
  const int sink_end = bridge.to;
  int most = bridge.capacity;
  int node = source_end;
  while (parent_[std::size_t(node)] != kTerminal) {
    const auto& up = arcs_[std::size_t(parent_[std::size_t(node)])];
    most = std::min(most, arcs_[std::size_t(up.twin)].capacity);
    node = up.to;
  }
  most = std::min(most, excess_[std::size_t(node)]);
  node = sink_end;
  while (parent_[std::size_t(node)] != kTerminal) {
    const auto& up = arcs_[std::size_t(parent_[std::size_t(node)])];
    most = std::min(most, up.capacity);
    node = up.to;
  }
  most = std::min(most, -excess_[std::size_t(node)]);

  bridge.capacity -= most;
  arcs_[std::size_t(bridge.twin)].capacity += most;
  const auto orphan = [&](int lost) {
    parent_[std::size_t(lost)] = kNone;
    orphans_.push_back(lost);
  };
  node = source_end;
  while (parent_[std::size_t(node)] != kTerminal) {
    auto& up = arcs_[std::size_t(parent_[std::size_t(node)])];
    auto& down = arcs_[std::size_t(up.twin)];
    const int above = up.to;
    up.capacity += most;
    down.capacity -= most;
    if (down.capacity == 0) orphan(node);
    node = above;
  }
  excess_[std::size_t(node)] -= most;
  if (excess_[std::size_t(node)] == 0) orphan(node);
  node = sink_end;
  while (parent_[std::size_t(node)] != kTerminal) {
    auto& up = arcs_[std::size_t(parent_[std::size_t(node)])];
    const int above = up.to;
    arcs_[std::size_t(up.twin)].capacity += most;
    up.capacity -= most;
    if (up.capacity == 0) orphan(node);
    node = above;
  }
  excess_[std::size_t(node)] += most;
  if (excess_[std::size_t(node)] == 0) orphan(node);
}

// Whether the node's line of parents ends at the terminal; marks the line with its distances.
bool MinCut::rooted(int node) {
  int steps = 0;
  int at = node;
  for (;;) {
    const auto a = std::size_t(at);
    if (stamp_[a] == now_) {
      steps += distance_[a];
      break;
    }
    if (parent_[a] == kNone) return false;
    if (parent_[a] == kTerminal) {
      stamp_[a] = now_;
      distance_[a] = 1;
      steps += 1;
      break;
    }
    ++steps;
    at = arcs_[std::size_t(parent_[a])].to;
  }
  for (at = node; stamp_[std::size_t(at)] != now_; at = arcs_[std::size_t(parent_[std::size_t(at)])].to) {
    stamp_[std::size_t(at)] = now_;
    distance_[std::size_t(at)] = steps--;
  }
  return true;
}

void MinCut::adopt(int orphan) {
  const auto o = std::size_t(orphan);
  const auto tree = tree_[o];
  int best = kNone;
  int least = std::numeric_limits<int>::max();
  for (int arc = first_arc_[o]; arc < first_arc_[o + 1]; ++arc) {
    const auto& a = arcs_[std::size_t(arc)];
    const auto to = std::size_t(a.to);
    // Flow comes from the parent in the source's tree and goes to it in the sink's.
    const int capacity = tree == kSourceTree ? arcs_[std::size_t(a.twin)].capacity : a.capacity;
    if (capacity == 0 || tree_[to] != tree || parent_[to] == kNone || !rooted(a.to)) continue;
    if (distance_[to] < least) {
      least = distance_[to];
      best = arc;
    }
  }
  parent_[o] = best;
  if (best != kNone) {
    stamp_[o] = now_;
    distance_[o] = least + 1;
    return;
  }
  for (int arc = first_arc_[o]; arc < first_arc_[o + 1]; ++arc) {
    const auto& a = arcs_[std::size_t(arc)];
    const auto to = std::size_t(a.to);
    if (tree_[to] != tree || parent_[to] == kNone) continue;
    const int capacity = tree == kSourceTree ? arcs_[std::size_t(a.twin)].capacity : a.capacity;
    if (capacity > 0) wake(a.to);
    if (parent_[to] >= 0 && arcs_[std::size_t(parent_[to])].to == orphan) {
      parent_[to] = kNone;
      orphans_.push_back(a.to);
    }
  }
  tree_[o] = kFree;
}

void MinCut::solve() {
  build();
  for (int node = 0; node < nodes_; ++node) {
    const auto n = std::size_t(node);
    if (excess_[n] == 0) continue;
    tree_[n] = excess_[n] > 0 ? kSourceTree : kSinkTree;
    parent_[n] = kTerminal;
    distance_[n] = 1;
    wake(node);
  }
  for (int middle = grow(); middle != kNone; middle = grow()) {
    ++now_;
    augment(middle);
    for (std::size_t i = 0; i < orphans_.size(); ++i) adopt(orphans_[i]);
    orphans_.clear();
  }
}

}  // namespace choreo::vision
