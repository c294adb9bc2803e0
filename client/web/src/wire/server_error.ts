// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { anyUnpack } from '@bufbuild/protobuf/wkt';
import { Code, ConnectError } from '@connectrpc/connect';
import { ErrorInfoSchema } from 'google/rpc/error_info_pb';
import type { Status } from 'google/rpc/status_pb';

/** The cause of a failed call, stream or edit: the server's status, with its reason (common.proto, ErrorReason). */
export class ServerError extends Error {
  override readonly name = 'ServerError';

  constructor(
    readonly code: Code,
    /** For example "OUT_OF_RANGE"; empty if the server, or a proxy before it, gave none. */
    readonly reason: string,
    message: string,
    readonly metadata: Readonly<Record<string, string>> = {},
  ) {
    super(message);
  }

  static fromConnect(error: unknown): ServerError {
    if (error instanceof ServerError) return error;
    const connect = ConnectError.from(error);
    const info = connect.findDetails(ErrorInfoSchema)[0];
    return new ServerError(connect.code, info?.reason ?? '', connect.rawMessage, info?.metadata);
  }

  /** From an EditResult's status, whose code is not 0. */
  static fromStatus(status: Status): ServerError {
    const info = status.details.map((detail) => anyUnpack(detail, ErrorInfoSchema)).find((found) => found);
    return new ServerError(status.code as Code, info?.reason ?? '', status.message, info?.metadata);
  }

  /**
   * From a WebSocket's close event: the code is 4000 plus the gRPC code, the text is "REASON: message". Other codes,
   * for example 1006 of a cut connection, become UNAVAILABLE.
   */
  static fromClose(code: number, text: string): ServerError {
    if (code <= 4000 || code > 4016) return new ServerError(Code.Unavailable, '', text || 'the connection is lost');
    const match = /^([A-Z_]+): (.*)$/s.exec(text);
    return new ServerError(code - 4000, match?.[1] ?? '', match?.[2] ?? text);
  }

  /** Whether the same call may succeed later. */
  get isPassing(): boolean {
    return [Code.Unavailable, Code.Internal, Code.Unknown, Code.Canceled, Code.DeadlineExceeded, Code.Aborted,
      Code.DataLoss, Code.ResourceExhausted].includes(this.code);
  }
}
