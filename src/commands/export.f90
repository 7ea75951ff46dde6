!> limber export: samples as columns. `limber export`. Floor: commands; results file -> text.
module limber_commands_export
   use limber_base_error, only: error_type, raise
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, one_line
   use limber_output_history_reader, only: stored_channel_type, history_reader_type
   implicit none
   private
   public :: export_history

contains

   !> Writes a comment line with the names and units of the columns, then one line for each sample: the time and the
   !> channels in the order asked for. A channel of width k makes k columns, name[1] to name[k]. The estimated error of a
   !> channel is asked for as name_error.
   subroutine export_history(path, names, unit, error)
      !> Name of the results file
      character(*), intent(in) :: path
      !> Names of channels, padded with blanks; none means all, in the order of the file, then all estimated errors
      character(*), intent(in) :: names(:)
      !> Open formatted unit; its lines must be free to be 25 characters a column long
      integer, intent(in) :: unit
      !> Allocated if the file or a channel cannot be read, or the Fortran library reports a failed write (that of
      !> gfortran keeps silent about a full device)
      type(error_type), allocatable, intent(out) :: error
      type(history_reader_type) :: reader
      real(wp), allocatable :: table(:, :)
      type(stored_channel_type), allocatable :: wanted(:)
      integer :: sample, status
      call reader%open(path, error)
      if (allocated(error)) return
      call find_wanted(reader, names, wanted, error)
      if (.not. allocated(error)) call read_table(reader, wanted, table, error)
      if (.not. allocated(error)) then
         write (unit, '(a)', iostat=status) one_line(header(reader, wanted))
         do sample = 1, reader%samples
            if (status /= 0) exit
            ! Three digits of exponent: without them Fortran drops the E of 1e-100
            write (unit, '(*(es24.16e3,:,1x))', iostat=status) table(:, sample)
         end do
         if (status /= 0) call raise(error, path//': cannot write the columns')
      end if
      call reader%close()
   end subroutine export_history

   !> The channels to write.
   subroutine find_wanted(reader, names, wanted, error)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: names(:)
      type(stored_channel_type), allocatable, intent(out) :: wanted(:)
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      if (size(names) == 0) then
         wanted = [reader%channels, reader%estimates]
         return
      end if
      allocate (wanted(size(names)))
      do i = 1, size(names)
         call reader%find_channel(trim(names(i)), wanted(i), error)
         if (allocated(error)) return
      end do
   end subroutine find_wanted

   !> Time and channels side by side, one sample in each Fortran column.
   subroutine read_table(reader, wanted, table, error)
      type(history_reader_type), intent(in) :: reader
      type(stored_channel_type), intent(in) :: wanted(:)
      real(wp), allocatable, intent(out) :: table(:, :)
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: time(:), values(:, :)
      integer :: i, row
      allocate (table(1 + sum(wanted%width), reader%samples))
      call reader%read_time(time, error)
      if (allocated(error)) return
      table(1, :) = time
      row = 1
      do i = 1, size(wanted)
         call reader%read_channel(wanted(i)%name, values, error)
         if (allocated(error)) return
         table(row + 1:row + size(values, 1), :) = values
         row = row + size(values, 1)
      end do
   end subroutine read_table

   !> Comment line with names and units of the columns.
   pure function header(reader, wanted) result(line)
      type(history_reader_type), intent(in) :: reader
      type(stored_channel_type), intent(in) :: wanted(:)
      character(:), allocatable :: line
      integer :: i, component
      line = '# time ['//reader%time_units//']'
      do i = 1, size(wanted)
         do component = 1, wanted(i)%width
            line = line//'  '//wanted(i)%name
            if (wanted(i)%width > 1) line = line//'['//as_text(component)//']'
            line = line//' ['//wanted(i)%units//']'
         end do
      end do
   end function header

end module limber_commands_export
