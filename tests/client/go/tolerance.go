// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

package main

import (
	"bytes"
	"context"
	"encoding/binary"
	"fmt"
	"io"
	"log"
	"math"
	"math/rand"
	"reflect"
	"sort"

	"latticed/v1"
)

const (
	tolerance = 0.002
	whole     = 4096 // the sum of a point's three integers
	seed      = 2014
)

// point holds barycentrics times whole. A side is split by its weight: see PatchPattern in event.proto.
type point [3]int64
type side struct {
	power  [3]int64 // 4^level of each edge
	sparse bool
}

func (s side) weight(p, q point) int64 {
	sum := int64(0)
	for e := 0; e < 3; e++ {
		term := -(q[e] - p[e]) * (q[(e+1)%3] - p[(e+1)%3]) * s.power[e]
		if !s.sparse && term < 0 {
			term = -term
		}
		sum += term
	}
	return sum
}

func (s side) splits(p, q point) bool { return s.weight(p, q) > whole*whole }

func middle(p, q point) point {
	return point{(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2}
}

func before(p, q point) bool {
	for c := 0; c < 3; c++ {
		if p[c] != q[c] {
			return p[c] < q[c]
		}
	}
	return false
}

// below is the order by (i_2, i_1).
func below(p, q point) bool {
	if p[2] != q[2] {
		return p[2] < q[2]
	}
	return p[1] < q[1]
}

// split adds the triangles that p, q, r becomes.
func (s side) split(p, q, r point, triangles *[][3]point) {
	corners := [3]point{p, q, r}
	count, at := 0, 0
	var cut [3]bool // side i joins corners i and i + 1
	for i := 0; i < 3; i++ {
		if cut[i] = s.splits(corners[i], corners[(i+1)%3]); cut[i] {
			count++
		}
	}
	for i := 0; i < 3; i++ {
		if (count == 1 && cut[i]) || (count == 2 && !cut[i]) {
			at = i
		}
	}
	p, q, r = corners[at], corners[(at+1)%3], corners[(at+2)%3]
	pq, qr, rp := middle(p, q), middle(q, r), middle(r, p)
	switch count {
	case 0:
		*triangles = append(*triangles, [3]point{p, q, r})
	case 1:
		s.split(p, pq, r, triangles)
		s.split(pq, q, r, triangles)
	case 2:
		s.split(rp, qr, r, triangles)
		fromP, fromQ := s.weight(p, qr), s.weight(q, rp)
		if fromP < fromQ || (fromP == fromQ && before(q, p)) {
			s.split(p, q, qr, triangles)
			s.split(p, qr, rp, triangles)
		} else {
			s.split(p, q, rp, triangles)
			s.split(q, qr, rp, triangles)
		}
	case 3:
		s.split(p, pq, rp, triangles)
		s.split(pq, q, qr, triangles)
		s.split(rp, qr, r, triangles)
		s.split(pq, qr, rp, triangles)
	}
}

// makePattern follows the rule of PatchPattern.
func makePattern(code uint32) *v1.PatchPattern {
	s := side{sparse: code>>9&1 == 1}
	largest := uint32(0)
	for e := uint32(0); e < 3; e++ {
		level := code >> (3 * e) & 7
		s.power[e] = 1 << (2 * level)
		if level > largest {
			largest = level
		}
	}
	var triangles [][3]point
	s.split(point{whole, 0, 0}, point{0, whole, 0}, point{0, 0, whole}, &triangles)

	numbers := map[point]int{}
	var points []point
	odd := int64(0)
	for _, triangle := range triangles {
		for _, p := range triangle {
			if _, known := numbers[p]; !known {
				numbers[p] = 0
				points = append(points, p)
				odd |= p[0] | p[1] | p[2]
			}
		}
	}
	denominator := int64(whole)
	for ; odd%2 == 0; odd /= 2 {
		denominator /= 2
	}
	scale := whole / denominator
	rowOf := func(p point) int64 { return p[2] / scale << largest / denominator }
	rows := map[int64]int{}
	var rowNumbers []int64
	for _, p := range points {
		if _, known := rows[rowOf(p)]; !known {
			rows[rowOf(p)] = 0
			rowNumbers = append(rowNumbers, rowOf(p))
		}
	}
	sort.Slice(rowNumbers, func(a, b int) bool { return rowNumbers[a] < rowNumbers[b] })
	for number, row := range rowNumbers {
		rows[row] = number
	}
	sort.Slice(points, func(a, b int) bool {
		p, q := points[a], points[b]
		row, other := rows[rowOf(p)], rows[rowOf(q)]
		if row != other {
			return row < other
		}
		if p[1] == q[1] {
			return (p[2] < q[2]) == (row%2 == 0)
		}
		return (p[1] < q[1]) == (row%2 == 0)
	})
	pattern := &v1.PatchPattern{Code: code, Denominator: uint32(denominator)}
	for number, p := range points {
		numbers[p] = number
		for _, i := range p {
			pattern.Points = append(pattern.Points, uint32(i/scale))
		}
	}
	for i, t := range triangles {
		first := 0
		for c := 1; c < 3; c++ {
			if below(t[c], t[first]) {
				first = c
			}
		}
		triangles[i] = [3]point{t[first], t[(first+1)%3], t[(first+2)%3]}
	}
	sort.Slice(triangles, func(a, b int) bool {
		t, u := triangles[a], triangles[b]
		if t[0] != u[0] {
			return below(t[0], u[0])
		}
		return below(u[1], t[1])
	})
	for _, t := range triangles {
		for _, p := range t {
			pattern.Triangles = append(pattern.Triangles, uint32(numbers[p]))
		}
	}
	return pattern
}

// patch is a patch of an update: its pattern and its points in world coordinates.
type patch struct {
	pattern *v1.PatchPattern
	points  [][3]float64
}

// byTolerance returns the patches of an update, in order, with the id of its topology and its certified error. It makes
// every pattern by itself, and checks that the server has sent the same before its first use.
func byTolerance(ctx context.Context, scenes v1.SceneServiceClient, scene string) ([]patch, string, float64) {
	view := &v1.ViewOptions{
		Encoding: v1.Encoding_ENCODING_RAW, Normals: v1.NormalMode_NORMAL_MODE_NONE,
		Segments: 32, Tolerance: tolerance,
	}
	stream, err := scenes.GetUpdate(ctx, &v1.GetUpdateRequest{Scene: scene, View: view})
	check(err)
	var origin *v1.Vec3
	topology, certified := "", 0.0
	sent := map[uint32]bool{}
	chunks := map[uint32][]patch{}
	for {
		event, err := stream.Recv()
		if err == io.EOF {
			break
		}
		check(err)
		if event.GetTopology() != nil {
			topology = event.GetTopology().TopologyId
		}
		if event.GetQuantisation() != nil {
			origin = event.GetQuantisation().Origin
		}
		for _, pattern := range event.GetPatterns().GetPatterns() {
			sent[pattern.Code] = true
			own := makePattern(pattern.Code)
			same := own.Denominator == pattern.Denominator && reflect.DeepEqual(own.Points, pattern.Points) &&
				reflect.DeepEqual(own.Triangles, pattern.Triangles)
			if !same {
				log.Fatalf("pattern %d is not that of the rule:\n%v\n%v", pattern.Code, pattern, own)
			}
		}
		for _, chunk := range event.GetChunks().GetChunks() {
			xyz := make([]float32, len(chunk.Data)/4)
			check(binary.Read(bytes.NewReader(chunk.Data), binary.LittleEndian, xyz))
			for i := 0; i < len(chunk.Levels); i += 2 {
				code := uint32(binary.LittleEndian.Uint16(chunk.Levels[i:]))
				if !sent[code] {
					log.Fatalf("pattern %d was not sent before its first use", code)
				}
				one := patch{pattern: makePattern(code)}
				for range one.pattern.Points[:len(one.pattern.Points)/3] {
					one.points = append(one.points, [3]float64{
						origin.X + float64(xyz[0]), origin.Y + float64(xyz[1]), origin.Z + float64(xyz[2])})
					xyz = xyz[3:]
				}
				chunks[chunk.Index] = append(chunks[chunk.Index], one)
			}
			if len(xyz) != 0 {
				log.Fatalf("chunk %d has %d numbers too many", chunk.Index, len(xyz))
			}
		}
		if event.GetUpdateEnd() != nil {
			certified = event.GetUpdateEnd().CertifiedError
		}
	}
	var patches []patch
	for i := uint32(0); int(i) < len(chunks); i++ {
		patches = append(patches, chunks[i]...)
	}
	return patches, topology, certified
}

// randomWeights returns barycentrics of a random point of a triangle.
func randomWeights(random *rand.Rand) [3]float64 {
	x, y := random.Float64(), random.Float64()
	if x+y > 1 {
		x, y = 1-x, 1-y
	}
	return [3]float64{1 - x - y, x, y}
}

// mixOf returns the point with these weights in the triangle of three of a patch's points.
func mixOf(points [][3]float64, corners []uint32, weights [3]float64) [3]float64 {
	var mix [3]float64
	for c, weight := range weights {
		for k := range mix {
			mix[k] += weight * points[corners[c]][k]
		}
	}
	return mix
}

// placeOf returns the place in the source mesh of the point with these weights in a triangle of a patch's pattern.
func placeOf(source *v1.TopologyPart, patch int, pattern *v1.PatchPattern, corners []uint32, weights [3]float64) *v1.SurfacePoint {
	var at [3]float64
	for c, weight := range weights {
		for k := range at {
			at[k] += weight * float64(pattern.Points[3*corners[c]+uint32(k)]) / float64(pattern.Denominator)
		}
	}
	place := &v1.SurfacePoint{Face: source.Faces[patch], Corners: source.Corners[3*patch : 3*patch+3]}
	for k := 0; k < 3; k++ {
		barycentric := 0.0
		for c := range at {
			barycentric += at[c] * source.Barycentrics[9*patch+3*c+k]
		}
		place.Barycentrics = append(place.Barycentrics, math.Min(math.Max(barycentric, 0), 1))
	}
	return place
}

func distance(p [3]float64, q []float64) float64 {
	return math.Sqrt(math.Pow(p[0]-q[0], 2) + math.Pow(p[1]-q[1], 2) + math.Pow(p[2]-q[2], 2))
}

// checkTolerance bends the scene and checks that random points of all triangles are within the certified error.
func checkTolerance(ctx context.Context, scenes v1.SceneServiceClient, scene *v1.Scene) {
	bend := &v1.MoveControlPoints{Offset: &v1.Vec3{Y: 0.2, Z: 0.5}}
	size := scene.Lattices[0].Size
	for i := int32(0); i < size.U*size.V*size.W; i += 3 {
		bend.Indices = append(bend.Indices, uint32(i))
	}
	_, err := scenes.ApplyEdits(ctx, &v1.EditBatch{
		Scene: scene.Id, EditorId: "go-smoke", Sequence: 2, StructureId: scene.StructureId,
		Edits: []*v1.Edit{{Edit: &v1.Edit_MoveControlPoints{MoveControlPoints: bend}}},
	})
	check(err)
	patches, topology, certified := byTolerance(ctx, scenes, scene.Id)
	stream, err := scenes.GetTopology(ctx, &v1.GetTopologyRequest{Scene: scene.Id, TopologyId: topology})
	check(err)
	source, err := stream.Recv()
	check(err)

	random := rand.New(rand.NewSource(seed))
	var wanted []*v1.SurfacePoint
	var chords [][3]float64
	for p, one := range patches {
		for t := 0; t < len(one.pattern.Triangles) && len(wanted) < 4096; t += 3 {
			corners, weights := one.pattern.Triangles[t:t+3], randomWeights(random)
			place, chord := placeOf(source, p, one.pattern, corners, weights), mixOf(one.points, corners, weights)
			wanted, chords = append(wanted, place), append(chords, chord)
		}
	}
	exact, err := scenes.EvaluatePoints(ctx, &v1.EvaluatePointsRequest{Scene: scene.Id,
		Points: &v1.EvaluatePointsRequest_SurfacePoints{SurfacePoints: &v1.SurfacePoints{Points: wanted}}})
	check(err)
	largest := 0.0
	for i, chord := range chords {
		largest = math.Max(largest, distance(chord, exact.Positions[3*i:3*i+3]))
	}
	fmt.Printf("tolerance %g: %d triangles, certified %g, %g at most at random points, seed %d\n",
		tolerance, len(wanted), certified, largest, seed)
	if !(certified > 0 && certified <= tolerance && largest <= certified && largest > certified/1000) {
		log.Fatal("the triangles are not within the certified error")
	}
}
