// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

package main

import (
	"context"
	"fmt"
	"io"
	"log"
	"math"
	"math/rand"

	"latticed/v1"
)

const (
	placesOfSpan  = 65535
	ownTolerance  = 0.001
	mostOfRequest = 4096 // points in EvaluatePoints
)

// axis is one axis of the lattice.
type axis struct {
	knots  []float64
	degree int
	breaks []float64 // distinct knots of the domain
}

func makeAxis(knots []float64, degree int32) axis {
	made := axis{knots: knots, degree: int(degree)}
	for _, knot := range knots[degree : len(knots)-int(degree)] {
		if len(made.breaks) == 0 || knot > made.breaks[len(made.breaks)-1] {
			made.breaks = append(made.breaks, knot)
		}
	}
	return made
}

// basis returns the value of every basis function at a local coordinate of a span, by the Cox-de Boor recursion.
func (a axis) basis(span int64, local float64) []float64 {
	low, high := a.breaks[span], a.breaks[span+1]
	u := (low+high)/2 + local*(high-low)
	values := make([]float64, len(a.knots)-1)
	for i := range values {
		if a.knots[i] == low && a.knots[i+1] == high {
			values[i] = 1
		}
	}
	for p := 1; p <= a.degree; p++ {
		for i := 0; i+p+1 < len(a.knots); i++ {
			left, right := 0.0, 0.0
			if a.knots[i+p] > a.knots[i] {
				left = (u - a.knots[i]) / (a.knots[i+p] - a.knots[i]) * values[i]
			}
			if a.knots[i+p+1] > a.knots[i+1] {
				right = (a.knots[i+p+1] - u) / (a.knots[i+p+1] - a.knots[i+1]) * values[i+1]
			}
			values[i] = left + right
		}
	}
	return values[:len(a.knots)-1-a.degree]
}

// position evaluates the point of a patch with these weights over a denominator, whose places are whole numbers.
func (p *plan) position(patch int, weights []uint32, denominator int64, axes [3]axis, controls []float64) [3]float64 {
	var values [3][]float64
	for a := range axes {
		sum, n := int64(0), int64(0)
		for _, vertex := range p.corners[patch] {
			sum += p.places[vertex][a]
		}
		span := int64(math.Max(0, math.Ceil(float64(sum)/(3*placesOfSpan))-1))
		for k, vertex := range p.corners[patch] {
			n += int64(weights[k]) * (p.places[vertex][a] - placesOfSpan*span)
		}
		if n == 0 && span > 0 {
			n, span = placesOfSpan*denominator, span-1
		}
		local := float64(2*n-placesOfSpan*denominator) / float64(2*placesOfSpan*denominator)
		values[a] = axes[a].basis(span, local)
	}
	var position [3]float64
	index := 0
	for _, w := range values[2] {
		for _, v := range values[1] {
			for _, u := range values[0] {
				for c := range position {
					position[c] += u * v * w * controls[index]
					index++
				}
			}
		}
	}
	return position
}

// patchesOf returns the lattice, the topology's id and all edge bytes of an update that has no points.
func patchesOf(ctx context.Context, scenes v1.SceneServiceClient, scene string) (*v1.Lattice, string, []byte) {
	view := &v1.ViewOptions{Encoding: v1.Encoding_ENCODING_PATCHES, Normals: v1.NormalMode_NORMAL_MODE_NONE}
	stream, err := scenes.GetUpdate(ctx, &v1.GetUpdateRequest{Scene: scene, View: view})
	check(err)
	var lattice *v1.Lattice
	topology := ""
	var edges []byte
	for {
		event, err := stream.Recv()
		if err == io.EOF {
			break
		}
		check(err)
		if event.GetLatticeState() != nil {
			lattice = event.GetLatticeState().Lattice
		}
		if event.GetTopology() != nil {
			topology = event.GetTopology().TopologyId
		}
		for _, chunk := range event.GetChunks().GetChunks() {
			end := int(chunk.FirstEdge) + len(chunk.Data)
			for len(edges) < end {
				edges = append(edges, 0)
			}
			copy(edges[chunk.FirstEdge:end], chunk.Data)
		}
	}
	return lattice, topology, edges
}

// checkPatches makes points and triangles from a patch plan and an update, and compares them with EvaluatePoints: points
// to half a unit of a grid of 16 bits, and random points of triangles to the tolerance in addition.
func checkPatches(ctx context.Context, scenes v1.SceneServiceClient, scene string) {
	lattice, topology, bytesOfEdges := patchesOf(ctx, scenes, scene)
	made := getPlan(ctx, scenes, scene, topology)
	edges, count := made.edges()
	if count != len(bytesOfEdges) || count != int(made.header.EdgeCount) {
		log.Fatalf("%d edges have %d bytes", count, len(bytesOfEdges))
	}
	axes := [3]axis{makeAxis(lattice.KnotsU, lattice.Degree.U), makeAxis(lattice.KnotsV, lattice.Degree.V),
		makeAxis(lattice.KnotsW, lattice.Degree.W)}
	stream, err := scenes.GetTopology(ctx, &v1.GetTopologyRequest{Scene: scene, TopologyId: topology})
	check(err)
	source, err := stream.Recv()
	check(err)

	random := rand.New(rand.NewSource(seed))
	low := [3]float64{math.Inf(1), math.Inf(1), math.Inf(1)}
	high := [3]float64{math.Inf(-1), math.Inf(-1), math.Inf(-1)}
	triangles := 0
	var wanted []*v1.SurfacePoint
	var points, chords [][3]float64
	for patch := range made.corners {
		code := uint32(0)
		for e, edge := range edges[patch] {
			code |= made.levelOf(bytesOfEdges[edge], ownTolerance) << (3 * e)
		}
		pattern := makePattern(code)
		triangles += len(pattern.Triangles) / 3
		var own [][3]float64
		for i := 0; i < len(pattern.Points); i += 3 {
			point := made.position(patch, pattern.Points[i:i+3], int64(pattern.Denominator), axes, lattice.ControlPoints)
			own = append(own, point)
			for c := range point {
				low[c], high[c] = math.Min(low[c], point[c]), math.Max(high[c], point[c])
			}
		}
		for t := 0; t+2 < len(pattern.Triangles) && len(wanted)+2 <= mostOfRequest; t += 3 {
			corners := pattern.Triangles[t : t+3]
			inside := randomWeights(random)
			wanted = append(wanted, placeOf(source, patch, pattern, corners, [3]float64{1, 0, 0}),
				placeOf(source, patch, pattern, corners, inside))
			points = append(points, own[corners[0]])
			chords = append(chords, mixOf(own, corners, inside))
		}
	}
	exact, err := scenes.EvaluatePoints(ctx, &v1.EvaluatePointsRequest{Scene: scene,
		Points: &v1.EvaluatePointsRequest_SurfacePoints{SurfacePoints: &v1.SurfacePoints{Points: wanted}}})
	check(err)
	extent := math.Max(high[0]-low[0], math.Max(high[1]-low[1], high[2]-low[2]))
	halfUnit := extent / 65535 / 2
	farthest, deepest := 0.0, 0.0
	for i := range points {
		farthest = math.Max(farthest, distance(points[i], exact.Positions[6*i:6*i+3]))
		deepest = math.Max(deepest, distance(chords[i], exact.Positions[6*i+3:6*i+6]))
	}
	fmt.Printf("patches: %d bytes of edges, tolerance %g: %d triangles, points %g of half a unit away, triangles %g\n",
		len(bytesOfEdges), ownTolerance, triangles, farthest/halfUnit, deepest)
	if farthest > halfUnit || deepest > ownTolerance+halfUnit || deepest < ownTolerance/1000 {
		log.Fatal("the patches are not the surface")
	}
}
