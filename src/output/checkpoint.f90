!> Checkpoint files. It is written under another name and then takes the place of the one before, so that there is always a whole
!> one. Floor: output.
!>
!>     /                  attributes format = "limber-checkpoint", format_version, samples, time
!>     /program, /run     texts: version and build of limber, number of the run
!>     /deck              text: the deck that is run
!>     /reals, /integers  the snapshot
!>
!> All of it is checked where it is read: the datasets by a checksum each (Fletcher32), the attributes and what leads to them by
!> those of HDF5's own structures (of version 1.10, `create_file`). A file of which a bit has changed is refused.
module limber_output_checkpoint
   use hdf5, only: hid_t
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_files, only: rename_file, remove_file
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_output_hdf5, only: create_file, open_file, close_file, write_attribute
   use limber_output_hdf5_checked, only: write_checked, write_checked_label
   use limber_output_hdf5_error, only: no_reason, no_id
   use limber_output_hdf5_read, only: read_attribute, read_dataset
   implicit none
   private
   public :: checkpoint_type, write_checkpoint, read_checkpoint, checkpoint_name, checkpoint_format

   character(*), parameter :: checkpoint_format = 'limber-checkpoint'
   integer, parameter :: checkpoint_version = 2

   !> What it says of its run
   type :: checkpoint_type
      !> Version and build of limber; number of the run; its deck
      character(:), allocatable :: program, run, deck
      !> Samples that its results had, and time reached
      integer :: samples = 0
      real(wp) :: time = 0.0_wp
   end type checkpoint_type

contains

   !> Name of the file beside some results.
   pure function checkpoint_name(results) result(name)
      character(*), intent(in) :: results
      character(:), allocatable :: name
      name = results
      if (len(name) > 3) then
         if (name(len(name) - 2:) == '.h5') name = name(:len(name) - 3)
      end if
      name = name//'.checkpoint.h5'
   end function checkpoint_name

   !> Writes a file, in place of an older one once it is whole.
   subroutine write_checkpoint(path, checkpoint, snapshot, error)
      character(*), intent(in) :: path
      type(checkpoint_type), intent(in) :: checkpoint
      !> That has been saved
      type(snapshot_type), intent(in) :: snapshot
      !> Allocated if it cannot be written; an older one is then left
      type(error_type), allocatable, intent(out) :: error
      type(error_type), allocatable :: close_error
      integer(hid_t) :: file
      logical :: ok
      call create_file(path//'.new', .true., file, error, checked=.true.)
      if (allocated(error)) return
      call write_checked_label(file, 'format', checkpoint_format, error)
      if (.not. allocated(error)) call write_attribute(file, '/', 'format_version', checkpoint_version, error)
      if (.not. allocated(error)) call write_attribute(file, '/', 'samples', checkpoint%samples, error)
      if (.not. allocated(error)) call write_attribute(file, '/', 'time', checkpoint%time, error)
      if (.not. allocated(error)) call write_checked(file, '/program', checkpoint%program, error)
      if (.not. allocated(error)) call write_checked(file, '/run', checkpoint%run, error)
      if (.not. allocated(error)) call write_checked(file, '/deck', checkpoint%deck, error)
      if (.not. allocated(error)) call write_checked(file, '/reals', snapshot%reals(:snapshot%real_count), error)
      if (.not. allocated(error)) call write_checked(file, '/integers', snapshot%integers(:snapshot%integer_count), error)
      call close_file(path//'.new', file, close_error)
      if (allocated(close_error) .and. .not. allocated(error)) call move_alloc(close_error, error)
      if (.not. allocated(error)) then
         call rename_file(path//'.new', path, ok)
         if (.not. ok) call raise(error, path//': cannot be replaced')
      end if
      if (allocated(error)) call remove_file(path//'.new')
   end subroutine write_checkpoint

   !> Reads a file.
   subroutine read_checkpoint(path, checkpoint, snapshot, error)
      character(*), intent(in) :: path
      type(checkpoint_type), intent(out) :: checkpoint
      !> Ready to restore from
      type(snapshot_type), intent(out) :: snapshot
      !> Allocated if it is missing, damaged, or something else
      type(error_type), allocatable, intent(out) :: error
      type(error_type), allocatable :: ignored
      integer(hid_t) :: file
      character(:), allocatable :: format
      real(wp), allocatable :: numbers(:)
      integer :: version
      !> Whether it is a checkpoint that this limber could go on from
      logical :: ours
      file = no_id
      call open_file(path, file, error)
      if (allocated(error)) return
      call read_attribute(file, '/', 'format', format, error)
      if (allocated(error) .or. format /= checkpoint_format) then
         if (allocated(error)) deallocate (error)
         call raise(error, path//' is not a checkpoint of limber', status_deck)
      end if
      if (.not. allocated(error)) call read_attribute(file, '/', 'format_version', version, error)
      if (.not. allocated(error)) then
         if (version /= checkpoint_version) call raise(error, path//' has version '//as_text(version)// &
            & ' of the format of checkpoints; this limber reads version '//as_text(checkpoint_version), status_deck)
      end if
      ours = .not. allocated(error)
      if (.not. allocated(error)) call read_attribute(file, '/', 'samples', checkpoint%samples, error)
      if (.not. allocated(error)) call read_attribute(file, '/', 'time', checkpoint%time, error)
      if (.not. allocated(error)) call read_dataset(file, '/program', checkpoint%program, error)
      if (.not. allocated(error)) call read_dataset(file, '/run', checkpoint%run, error)
      if (.not. allocated(error)) call read_dataset(file, '/deck', checkpoint%deck, error)
      if (.not. allocated(error)) call read_dataset(file, '/reals', snapshot%reals, error)
      if (.not. allocated(error)) call read_dataset(file, '/integers', numbers, error)
      if (.not. allocated(error)) allocate (snapshot%integers, source=nint(numbers))
      if (allocated(error) .and. ours) call tell_damage(path, error)
      call close_file(path, file, ignored)
   end subroutine read_checkpoint

   !> Says of a checkpoint that cannot be read to its end that it is damaged, and what to do.
   subroutine tell_damage(path, error)
      character(*), intent(in) :: path
      !> Why; on return what is told of it
      type(error_type), allocatable, intent(inout) :: error
      character(*), parameter :: none = ': '//no_reason
      character(:), allocatable :: text
      integer :: at
      text = error%message
      if (index(text, path//': ') == 1) text = text(len(path) + 3:)
      at = index(text, none)
      if (at > 0) text = text(:at - 1)//text(at + len(none):)
      deallocate (error)
      call raise(error, path//' is damaged: '//text//'; the run cannot go on from it, --force without --restart begins anew', &
         & status_deck)
   end subroutine tell_damage

end module limber_output_checkpoint
