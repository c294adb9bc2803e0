// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

// Smoke is a client of latticed made only from protoc's output. It asks the server what it can do, uploads
// a triangle, creates a scene of it and moves all control points by 1 along x. It checks that the smallest x
// of the update has moved by 1, that triangles by a tolerance are within their certified error (tolerance.go), that
// patches that it evaluates by itself are the surface (patches.go), and that a call for a deleted scene fails with
// NOT_FOUND.
package main

import (
	"bytes"
	"context"
	"encoding/binary"
	"fmt"
	"io"
	"log"
	"math"
	"os"
	"time"

	"google.golang.org/grpc"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/metadata"
	"google.golang.org/grpc/status"
	"google.golang.org/protobuf/proto"

	"latticed/v1"
)

const (
	triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
	offset   = 1.0
)

// codec encodes messages of google.golang.org/protobuf. Debian's grpc is too old to know them.
type codec struct{}

func (codec) Marshal(message interface{}) ([]byte, error) {
	return proto.Marshal(message.(proto.Message))
}
func (codec) Unmarshal(data []byte, message interface{}) error {
	return proto.Unmarshal(data, message.(proto.Message))
}
func (codec) Name() string { return "proto" }

func check(err error) {
	if err != nil {
		log.Fatal(err)
	}
}

// ask checks that the server describes itself and can do all that this client needs.
func ask(ctx context.Context, server v1.ServerServiceClient) {
	info, err := server.GetServerInfo(ctx, &v1.GetServerInfoRequest{})
	check(err)
	fmt.Printf("latticed %s on %s: at most %d patches\n", info.Version, info.Backends[0].Name, info.Limits.MaxPatches)
	raw, obj := false, false
	for _, encoding := range info.Encodings {
		raw = raw || encoding == v1.Encoding_ENCODING_RAW
	}
	for _, format := range info.MeshFormats {
		obj = obj || format == v1.MeshFormat_MESH_FORMAT_OBJ
	}
	if !raw || !obj || info.BootId == "" || info.Limits.MaxMeshBytes < uint64(len(triangle)) {
		log.Fatalf("the server lacks what this client needs: %v", info)
	}
}

func upload(ctx context.Context, meshes v1.MeshServiceClient) *v1.Mesh {
	stream, err := meshes.UploadMesh(ctx)
	check(err)
	header := &v1.MeshHeader{Format: v1.MeshFormat_MESH_FORMAT_OBJ, TotalBytes: uint64(len(triangle))}
	check(stream.Send(&v1.UploadMeshRequest{Message: &v1.UploadMeshRequest_Header{Header: header}}))
	data := &v1.UploadMeshRequest_Data{Data: []byte(triangle)}
	check(stream.Send(&v1.UploadMeshRequest{Message: data}))
	mesh, err := stream.CloseAndRecv()
	check(err)
	return mesh
}

func move(ctx context.Context, scenes v1.SceneServiceClient, scene *v1.Scene) *v1.EditResult {
	size := scene.Lattices[0].Size
	move := &v1.MoveControlPoints{Offset: &v1.Vec3{X: offset}}
	for i := int32(0); i < size.U*size.V*size.W; i++ {
		move.Indices = append(move.Indices, uint32(i))
	}
	result, err := scenes.ApplyEdits(ctx, &v1.EditBatch{
		Scene: scene.Id, EditorId: "go-smoke", Sequence: 1, StructureId: scene.StructureId,
		Edits: []*v1.Edit{{Edit: &v1.Edit_MoveControlPoints{MoveControlPoints: move}}},
	})
	check(err)
	return result
}

// leftmost returns the smallest x of an update's points, in world coordinates, and the number of points.
func leftmost(ctx context.Context, scenes v1.SceneServiceClient, scene string, revision uint64) (float64, int) {
	view := &v1.ViewOptions{
		Encoding: v1.Encoding_ENCODING_RAW, Normals: v1.NormalMode_NORMAL_MODE_NONE, Segments: 4,
	}
	stream, err := scenes.GetUpdate(ctx, &v1.GetUpdateRequest{Scene: scene, MinRevision: revision, View: view})
	check(err)
	origin, lowest, points := 0.0, math.Inf(1), 0
	for {
		event, err := stream.Recv()
		if err == io.EOF {
			return lowest, points
		}
		check(err)
		if grid := event.GetQuantisation(); grid != nil {
			origin = grid.GetOrigin().GetX()
		}
		for _, chunk := range event.GetChunks().GetChunks() {
			xyz := make([]float32, len(chunk.Data)/4)
			check(binary.Read(bytes.NewReader(chunk.Data), binary.LittleEndian, xyz))
			points += len(xyz) / 3
			for i := 0; i < len(xyz); i += 3 {
				lowest = math.Min(lowest, origin+float64(xyz[i]))
			}
		}
	}
}

func main() {
	log.SetFlags(0)
	ctx, cancel := context.WithTimeout(context.Background(), time.Minute)
	defer cancel()
	connection, err := grpc.DialContext(ctx, os.Getenv("LATTICED_SERVER"), grpc.WithInsecure(),
		grpc.WithDefaultCallOptions(grpc.ForceCodec(codec{})))
	check(err)
	defer connection.Close()
	ask(ctx, v1.NewServerServiceClient(connection))
	meshes, scenes := v1.NewMeshServiceClient(connection), v1.NewSceneServiceClient(connection)

	id := fmt.Sprintf("go-smoke-%d", os.Getpid())
	mesh := upload(ctx, meshes)
	ctx = metadata.AppendToOutgoingContext(ctx, "latticed-scene", id)
	scene, err := scenes.CreateScene(ctx, &v1.CreateSceneRequest{SceneId: id, Mesh: mesh.Id})
	check(err)
	rest, count := leftmost(ctx, scenes, id, 0)
	result := move(ctx, scenes, scene)
	moved, _ := leftmost(ctx, scenes, id, result.Revision)
	fmt.Printf("revision %d: %d patches, %d points, leftmost %g, was %g\n",
		result.Revision, scene.Patches, count, moved, rest)
	if result.Revision != 1 || count != 15*int(scene.Patches) || math.Abs(moved-rest-offset) > 1e-6 {
		log.Fatal("the update does not match the edit")
	}
	checkTolerance(ctx, scenes, scene)
	checkPatches(ctx, scenes, scene.Id)

	_, err = scenes.DeleteScene(ctx, &v1.DeleteSceneRequest{Scene: id})
	check(err)
	_, err = scenes.GetLattice(ctx, &v1.GetLatticeRequest{Scene: id})
	fmt.Println("after its deletion:", status.Convert(err).Message())
	if status.Code(err) != codes.NotFound {
		log.Fatalf("a deleted scene is %v", err)
	}
}
