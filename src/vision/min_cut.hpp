// SPDX-License-Identifier: Apache-2.0
// The cheapest way to part a graph in two: which nodes go with the source, which with the sink.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace choreo::vision {

/// A minimum cut by augmenting paths from two search trees that are kept from path to path.
///
/// All weights are whole numbers, so that the result is the same on every machine.
/// @source Boykov and Kolmogorov, An Experimental Comparison of Min-Cut/Max-Flow Algorithms, PAMI 26 (2004), section 3.
class MinCut {
 public:
  explicit MinCut(int nodes);

  /// Adds to the cost of `node`: `if_sink` where it ends with the sink, `if_source` where with the source; 0 or more.
  void add_cost(int node, int if_sink, int if_source);

  /// Adds what it costs to part two different nodes; 0 or more.
  void join(int a, int b, int weight);

  /// Finds the cut. Once only.
  /// @cost  near linear in practice; allocates the graph's arcs.
  void solve();

  /// Whether the node went with the source; what could go either way goes with the sink.
  [[nodiscard]] bool with_source(int node) const { return tree_[std::size_t(node)] == kSourceTree; }

 private:
  enum Tree : std::uint8_t { kFree, kSourceTree, kSinkTree };
  struct Arc {
    int to;
    int twin;      // The arc back.
    int capacity;  // What is left.
  };
  struct Join {
    int a, b, weight;
  };
  static constexpr int kNone = -1, kTerminal = -2;

  void build();
  void wake(int node);
  [[nodiscard]] int residual_towards(int arc, Tree tree) const;
  int grow();
  void augment(int middle);
  void adopt(int orphan);
  [[nodiscard]] bool rooted(int node);

  int nodes_;
  std::vector<Join> joins_;
  std::vector<int> excess_;     // Above 0: capacity from the source; below: to the sink.
  std::vector<int> first_arc_;  // Of each node, and one behind the last.
  std::vector<Arc> arcs_;
  std::vector<int> parent_;  // Arc from the node to its parent, kTerminal or kNone.
  std::vector<Tree> tree_;
  std::vector<std::uint8_t> waiting_;
  std::vector<int> active_;
  std::size_t next_active_ = 0;
  std::vector<int> orphans_;
  // Distance to the terminal, right where the stamp is of now.
  std::vector<int> distance_, stamp_;
  int now_ = 0;
};

}  // namespace choreo::vision
